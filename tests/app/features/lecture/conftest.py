"""Fixtures: servers with a lecture, and their classes."""

from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest

from app.features.lecture.lecture_options import LectureOptions
from app.features.store.store_options import StoreOptions
from app.hosting.serve_options import FeatureOptions
from app.settings import Settings
from app.start import App
from app.web.headless_client import Mirror
from scenes.settings import changed
from tests.app.conftest import Join, OpenHouse
from tests.app.features.lecture.lecture_room import Class, Come, tab_of
from tests.app.features.lecture.presenter_stage import Stage
from tests.blocking_client import BlockingClient


@pytest.fixture
def house(house: OpenHouse) -> OpenHouse:
    """The core's `house`, which also takes the options of a lecture and of the store:
    `house(lecture=True, watchers=…, students=…, store=…, keep=…, …)`."""

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


@pytest.fixture
def come(join: Join, monkeypatch: pytest.MonkeyPatch) -> Come:
    """`come(house, "ann")`: a student whose tab has an id; `come(house, key=KEY)`: a teacher. Each page
    records all received messages, see `everything`."""
    take = Mirror.take

    def remember(mirror: Mirror, message: dict[str, Any]) -> None:
        vars(mirror).setdefault("heard", []).append(repr(message))
        take(mirror, message)

    def make(house: App, name: str = "", query: str = "", key: str = "") -> BlockingClient:
        tab = f"resume={tab_of(name)}" if name else ""
        return join(house, "&".join(part for part in (tab, query, key and f"key={quote(key)}") if part))

    monkeypatch.setattr(Mirror, "take", remember)
    return make


@pytest.fixture
def classroom(house: OpenHouse, come: Come) -> Class:
    """A lecture with a key and its teacher in lesson 1."""
    return Class(house, come)


@pytest.fixture
def stage(fast_machine: None) -> Stage:
    """A lecture's shared session at the first question, without a server."""
    del fast_machine
    return Stage()


@pytest.fixture(scope="module")
def lasting_lecture(lasting_house: OpenHouse) -> Callable[[str], App]:
    """`lasting_lecture(key)`: a lecture for all tests of a file, with the fast picture on its pages."""
    features = LectureOptions(lecture=True), StoreOptions(file=None)
    return lambda key: lasting_house(changed(Settings(), "picture", "fast"), key=key, features=features)
