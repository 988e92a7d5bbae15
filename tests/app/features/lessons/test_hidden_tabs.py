"""Tests of lessons beside those of the core in the file `test_hidden_tabs.py`."""

from pathlib import Path

from app.hosting.record_writer import BEAT

from app.hosting.frame_loop import LIVELY
from tests.app.conftest import Made, visitor_of
from tests.app.features.lessons.helpers import progress_in
from tests.app.hosting.test_hidden_tabs import drawn
from tests.app.page.helpers import click
from tests.app.runtime.processes import until
from tests.app.stores import find


def test_after_a_rest_what_a_visitor_does_is_saved_at_once(by_hand: Made, tmp_path: Path) -> None:
    opened, query = by_hand(sessions=3, store=tmp_path / "store"), {"resume": "0123456789abcdef" * 2}
    page = opened.let_in(f"lesson=3&step=2&resume={query['resume']}")
    for choice, rest in enumerate((0.0, 4.0, 25.0)):
        drawn(opened, LIVELY + rest)
        click(page, f"{choice + 1} ")
        until(lambda: len(visitor_of(opened).session.posts) > 0)
        # The writer takes up to `BEAT` more.
        drawn(opened, 2.0 - BEAT)
        record = find(opened.house.context.store, query)
        assert [done.choice for done in progress_in(record).steps.values()] == [choice]
