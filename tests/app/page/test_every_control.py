"""Every control changes one setting of one visitor, and no value from outside gets in."""

import math
from typing import Any

import pytest

from app.session.session import Session
from scenes.settings import values
from tests.app.conftest import Arrive, OpenHouse, ask, live_sessions
from tests.app.page.helpers import ON_PAGE, SPECS, another, bring_into_view, notes, page_label, roundtrip
from tests.tools.monkey.visitor import assert_sound

NAN, INF = math.nan, math.inf


def bad_values(key: str, present: Any) -> list[Any]:
    """What no control of this kind sends."""
    spec = SPECS[key]
    if spec.choices:
        return ["nonsense", "", spec.choices[0], "x" * 5000]
    if isinstance(present, bool):
        return []
    low, high = spec.low * spec.page_scale, spec.high * spec.page_scale
    return [NAN, INF, -INF, 1e9, -1e9, 1e308, low - spec.step, high + spec.step] + [high * (1.0 + 1e-7)] * isinstance(
        present, float
    )


def test_every_control_changes_one_setting_of_one_visitor_and_no_bad_value_gets_in(house: OpenHouse, arrive: Arrive) -> None:
    assert sorted(ON_PAGE) == sorted(set(SPECS) - {"speed", "plot"}), "every setting has its place"
    opened = house()
    one, other = arrive(opened), arrive(opened, "autopilot=0&dm=0.12")
    theirs = values(other.session.settings)
    for key in ON_PAGE:
        bring_into_view(one.session, key)
        one.visitor.wait_for(lambda v, key=key: v.mirror.labelled(page_label(key))["visible"])
        before = values(one.session.settings)
        for value in bad_values(key, before[key]):
            one.visitor.set_value(page_label(key), value)
        roundtrip(one)
        after = values(one.session.settings)
        assert {k for k in after if after[k] != before[k]} == {"g"}, key
        sent, expected = another(key, after[key])
        one.visitor.set_value(page_label(key), sent)
        one.wait(lambda s, key=key, expected=expected: values(s.settings)[key] == pytest.approx(expected, abs=1e-9))
        now = values(one.session.settings)
        assert {k for k in now if now[k] != after[k]} == {key}
        assert one.session.simulation.settings == one.session.settings.run and values(other.session.settings) == theirs, key
        one.run_on(0.05)
        one.ask(assert_sound)
    ask(one.session, lambda s: s.change("scene", "hold"))
    one.run_on(0.3)
    other.run_on(0.3)
    one.ask(assert_sound)
    assert one.session.simulation.room.rig.name == "table" and other.session.simulation.room.rig.name == "torso"


def test_what_one_visitor_does_leaves_the_arms_of_another_as_they_were_to_the_last_bit(house: OpenHouse, arrive: Arrive) -> None:
    opened = house()
    one, other = arrive(opened), arrive(opened, "seed=5&guided=left")
    for key in ("law", "dm", "n", "v", "rig"):
        one.visitor.set_value(page_label(key), another(key, values(one.session.settings)[key])[0])
        one.run_on(0.1)
    table, settings = other.ask(lambda s: (s.simulation.history.table(), s.settings))
    alone = Session(settings)
    while alone.simulation.steps < len(table):
        alone.advance(alone.settings.run.dt)
    assert len(table) > 50
    assert alone.simulation.history.table().tobytes() == table.tobytes()


def test_wrong_types_cost_only_the_own_connection(house: OpenHouse, arrive: Arrive) -> None:
    opened = house()
    witness = arrive(opened)
    before = values(witness.session.settings)
    for key in ON_PAGE:
        wrong: list[Any] = [None, [1, 2], {"a": 1}, b"\x00", 3 if SPECS[key].choices or isinstance(before[key], bool) else "wide"]
        for value in wrong[ON_PAGE.index(key) % 5 :: 5]:
            victim = arrive(opened)
            victim.visitor.set_value(page_label(key), value)
            victim.visitor.wait_for(lambda v: v.closed)
            assert victim.visitor.closed is not None and victim.visitor.closed.rcvd is not None
            assert victim.visitor.closed.rcvd.code == 1008
            assert values(victim.session.settings) == before
            witness.wait(lambda _, number=victim.number: number not in live_sessions(opened))
    witness.run_on(0.1)
    assert values(witness.session.settings) == before and set(live_sessions(opened)) == {witness.number}
    witness.ask(assert_sound)


def test_a_refused_value_is_named_and_written_back(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house())
    # A hair over the edge: near enough for the door, which leaves room for a browser's rounding, but not for the settings.
    one.visitor.set_value("d_m [mm]", 300.0 * (1.0 + 5e-7))
    one.visitor.wait_for(lambda _: any("dm = 0.3" in note for note in notes(one.visitor)))
    one.visitor.wait_for(lambda v: v.mirror.labelled("d_m [mm]")["value"] == 150.0)
    assert one.session.settings.run.law.critical_distance == 0.15
    one.visitor.set_value("d_m [mm]", 300.0)
    one.wait(lambda s: s.settings.run.law.critical_distance == 0.3)
