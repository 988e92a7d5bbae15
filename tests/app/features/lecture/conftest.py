"""Houses that hold a lecture."""

from pathlib import Path
from typing import Any

import pytest

from app.features.lecture.lecture_options import LectureOptions
from app.features.store.store_options import StoreOptions
from app.hosting.serve_options import FeatureOptions
from app.start import App
from tests.app.conftest import OpenHouse


@pytest.fixture
def house(house: OpenHouse) -> OpenHouse:
    """`house(lecture=True, watchers=…, students=…, store=…, keep=…, …)` is the core's, which also takes the options of a lecture and of
    the store."""

    def make(
        *given: Any,
        lecture: bool = False,
        watchers: int = 200,
        students: int = 0,
        store: Path | None = None,
        keep: float = 24.0,
        features: tuple[FeatureOptions, ...] = (),
        **options: Any,
    ) -> App:
        mine = LectureOptions(lecture=lecture, watchers=watchers, students=students)
        return house(*given, features=(mine, StoreOptions(file=store, keep=keep), *features), **options)

    return make
