"""The store on the page; pages save seldom at rest and at once after a rest."""

import json
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any
from urllib.request import urlopen

import pytest

from app.features.store import record_writer
from app.features.store.record_writer import BEAT
from app.features.store.session_store import store_of
from app.features.store.store_file import StoreFile
from app.features.store.store_options import StoreOptions
from app.hosting import visitor as visitor_module
from app.hosting.frame_loop import LIVELY
from app.hosting.visitor import SAVING, SAVING_AT_REST
from app.session.actions import Pause
from tests.app.conftest import Join, Made, OpenHouse, live_sessions, private_of, visitor_of
from tests.app.features.lessons.helpers import progress_in
from tests.app.hosting.test_hidden_tabs import drawn
from tests.app.page.helpers import click, notes
from tests.app.runtime.processes import until
from tests.app.stores import find

WORD = "0123456789abcdef0123456789abcdef"


def kept_in(path: Path) -> tuple[StoreOptions]:
    """Options of a server with this store file."""
    return (StoreOptions(file=path),)


def test_an_unwritable_disk_is_reported_once_and_the_session_continues(
    house: OpenHouse, join: Join, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(record_writer, "AGAIN", 0.2)
    monkeypatch.setattr(visitor_module, "SAVING", 0.1)
    opened = house(features=kept_in(tmp_path / "store"))
    store = store_of(opened.context)
    assert store.file is not None and store.file.file is not None
    visitor = join(opened, f"resume={WORD}")
    visitor.wait_for(lambda _: live_sessions(opened), 60.0)
    (session,) = live_sessions(opened).values()
    file = store.file.file
    file.connection.execute("PRAGMA max_page_count = 1")
    visitor.wait_for(lambda v: any("disk" in note for note in notes(v)), 60.0)
    assert store.file.file is file, "the file must still be read"
    file.connection.execute("PRAGMA max_page_count = 1000000")
    steps = session.simulation.steps
    visitor.wait_for(lambda _: not store.state.problem and session.simulation.steps > steps + 100, 60.0)
    assert len([note for note in notes(visitor) if "disk" in note]) == 1


def test_the_pages_say_that_the_store_was_damaged(house: OpenHouse, join: Join, tmp_path: Path) -> None:
    opened = house(features=kept_in(tmp_path / "store"))
    store = store_of(opened.context)
    assert store.file is not None and store.file.file is not None
    visitor = join(opened, f"resume={WORD}")
    assert not any("damaged" in note for note in notes(visitor))
    with closing(sqlite3.connect(tmp_path / "store", timeout=60.0)) as file:
        file.execute("DROP TABLE parts")
    visitor.wait_for(lambda v: any("damaged" in note for note in notes(v)), 60.0)
    later = join(opened, f"resume={WORD[::-1]}")
    later.wait_for(lambda v: any("damaged" in note for note in notes(v)), 60.0)
    assert store.state.set_aside and not store.state.problem
    assert [len([note for note in notes(one) if "damaged" in note]) for one in (visitor, later)] == [1, 1]


def test_the_health_names_problems_of_the_store(house: OpenHouse, tmp_path: Path) -> None:
    def state_with(store: Path | None) -> dict[str, object]:
        with urlopen(
            f"{house(features=() if store is None else kept_in(store)).url}/healthz", timeout=60.0
        ) as answer:
            return json.load(answer)["store"]

    whole, damaged = tmp_path / "whole", tmp_path / "damaged"
    well = {"lasting": True, "problem": "", "set_aside": ""}
    assert state_with(None) == {**well, "lasting": False}
    assert state_with(whole) == well
    StoreFile(damaged, 10**9).close()
    damaged.write_bytes(damaged.read_bytes()[:9_000])
    aside = str(state_with(damaged)["set_aside"])
    assert (tmp_path / aside).stat().st_size == 9_000
    (tmp_path / "file").touch()
    # Without the path, which is private to the user.
    assert state_with(tmp_path / "file" / "store") == {**well, "problem": "File exists"}


def test_a_page_at_rest_is_saved_seldom(
    by_hand: Made, tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = by_hand(sessions=3, features=kept_in(tmp_path / "store"))
    opened.let_in(f"resume={'0123456789abcdef' * 2}")
    visitor, saved = visitor_of(opened), []
    save = visitor.save
    monkeypatch.setattr(visitor, "save", lambda: saved.append(opened.now) or save())
    drawn(opened, 10.0)
    assert len(saved) == pytest.approx(10.0 / SAVING, abs=1)
    visitor.session.post(Pause())
    drawn(opened, LIVELY + 2.0 * SAVING)
    saved.clear()
    drawn(opened, 2.0 * SAVING_AT_REST)
    assert len(saved) == pytest.approx(2, abs=1)


def test_an_action_after_a_rest_is_saved_at_once(by_hand: Made, tmp_path: Path) -> None:
    opened, query = (
        by_hand(sessions=3, features=kept_in(tmp_path / "store")),
        {"resume": "0123456789abcdef" * 2},
    )
    page = opened.let_in(f"lesson=3&step=2&resume={query['resume']}")
    for choice, rest in enumerate((0.0, 4.0, 25.0)):
        drawn(opened, LIVELY + rest)
        click(page, f"{choice + 1} ")
        until(lambda: len(visitor_of(opened).session.posts) > 0)
        # The writer takes up to `BEAT` longer.
        drawn(opened, 2.0 - BEAT)
        record = find(opened.house.context.store, query)
        assert [done.choice for done in progress_in(record).steps.values()] == [choice]


def test_a_duplicated_tab_finds_the_record_of_the_later_page_by_another_link(by_hand: Made) -> None:
    opened = by_hand(sessions=8)
    opened.let_in(f"n=8&resume={WORD}")
    second = opened.let_in(f"n=8&resume={WORD}")
    session = list(private_of(opened).visitors.values())[-1].session
    session.change("dm", 0.2)
    opened.leave(second)
    opened.frames()
    record = find(opened.house.context.store, {"resume": WORD, "n": "9"})
    assert record is not None and record.settings == session.settings
