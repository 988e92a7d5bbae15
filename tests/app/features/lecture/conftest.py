"""Houses that hold a lecture."""

from typing import Any

import pytest

from app.features.lecture.lecture_options import LectureOptions
from app.start import App
from tests.app.conftest import OpenHouse


@pytest.fixture
def house(house: OpenHouse) -> OpenHouse:
    """`house(lecture=True, watchers=…, students=…, …)` is the core's, which also takes the options of a lecture."""

    def make(*given: Any, lecture: bool = False, watchers: int = 200, students: int = 0, **options: Any) -> App:
        mine = LectureOptions(lecture=lecture, watchers=watchers, students=students)
        return house(*given, features=(mine,), **options)

    return make
