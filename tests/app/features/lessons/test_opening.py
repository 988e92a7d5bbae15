"""Lesson cases of the core's `test_opening.py`."""

from app.features.lessons.panel.welcome import is_for_newcomers
from tests.app.conftest import Arrive, OpenHouse
from tests.app.page.helpers import open_lessons, shown


def test_links_with_content_show_no_greeting(house: OpenHouse, arrive: Arrive) -> None:
    private = house()
    arrive(private).visitor.wait_for(lambda v: "duet-welcome" in shown(v))
    for key, value in {"lesson": "1", "rig": "table", "whole": "1"}.items():
        assert not is_for_newcomers({key: value})
        assert "duet-welcome" not in shown(arrive(private, f"{key}={value}").visitor)
    assert is_for_newcomers({"theme": "dark", "lang": "sl", "resume": "x", "window": "1x1"})
    one = arrive(private)
    open_lessons(one.visitor)
    one.visitor.wait_for(lambda v: "Start lesson 1" not in shown(v))
