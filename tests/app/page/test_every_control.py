"""Controls and handles change only their own visitor's settings and hand, and bad values are refused."""

import math
from typing import Any

import numpy as np
import pytest

from app.session.session import Session
from app.settings import Settings, first_settings
from scenes.settings import values
from scenes.targets import HandTarget, JointTarget
from tests.app.conftest import ELBOW, HAND, Arrive, OpenHouse, ask
from tests.app.page.helpers import (
    ON_PAGE,
    SPECS,
    another,
    bring_into_view,
    notes,
    page_label,
    press,
    roundtrip,
)
from tests.tools.monkey.visitor import assert_sound

NAN, INF = math.nan, math.inf


def bad_values(key: str, present: Any) -> list[Any]:
    """Values that a control of this kind never sends."""
    spec = SPECS[key]
    if spec.choices:
        return ["nonsense", "", spec.choices[0], "x" * 5000]
    if spec.read is not None:
        return ["nonsense", "", "0.2:1,0.1:0", "x" * 5000]
    if isinstance(present, bool):
        return []
    low, high = spec.low * spec.page_scale, spec.high * spec.page_scale
    return [NAN, INF, -INF, 1e9, -1e9, 1e308, low - spec.step, high + spec.step] + [
        high * (1.0 + 1e-7)
    ] * isinstance(present, float)


@pytest.mark.thorough
def test_each_control_changes_one_setting_and_refuses_bad_values(house: OpenHouse, arrive: Arrive) -> None:
    assert sorted(ON_PAGE) == sorted(set(SPECS) - {"speed", "plot"}), "a setting has no control"
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
        one.wait(
            lambda s, key=key, expected=expected: values(s.settings)[key] == pytest.approx(expected, abs=1e-9)
        )
        now = values(one.session.settings)
        assert {k for k in now if now[k] != after[k]} == {key}
        # Asked in the session's thread: the run is rebuilt only after its settings have changed.
        assert (
            one.ask(lambda s: s.simulation.settings == s.settings.run)
            and values(other.session.settings) == theirs
        ), key
        one.run_on(0.05)
        one.ask(assert_sound)
    ask(one.session, lambda s: [s.change("scene", "hold"), s.change("rig", "table")])
    one.run_on(0.3)
    other.run_on(0.3)
    one.ask(assert_sound)
    assert (
        one.session.simulation.room.rig.name == "table" and other.session.simulation.room.rig.name == "torso"
    )


def test_one_visitors_actions_do_not_change_a_bit_of_anothers_run(house: OpenHouse, arrive: Arrive) -> None:
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


def test_a_refused_value_is_named_and_written_back(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house())
    # Just over the limit: the gate allows for a browser's rounding, the settings do not.
    one.visitor.set_value("critical distance d_m [mm]", 300.0 * (1.0 + 5e-7))
    one.visitor.wait_for(lambda _: any("dm = 0.3" in note for note in notes(one.visitor)))
    one.visitor.wait_for(lambda v: v.mirror.labelled("critical distance d_m [mm]")["value"] == 150.0)
    assert one.session.settings.run.law.critical_distance == 0.15
    one.visitor.set_value("critical distance d_m [mm]", 300.0)
    one.wait(lambda s: s.settings.run.law.critical_distance == 0.3)


def test_bad_poses_of_a_handle_are_ignored_or_limited(house: OpenHouse, arrive: Arrive) -> None:
    opened = house()
    one, witness = arrive(opened, "gizmo=1"), arrive(opened)
    place, turn = (0.3, 0.0, 1.0), (0.5, 0.5, 0.5, 0.5)
    places = ((NAN, 0.0, 1.0), (0.3, INF, 1.0), (0.3, 0.0, -INF), (1e308, 0.0, 1.0), (1e8, -1e8, 1e8))
    turns = ((0.0, 0.0, 0.0, 0.0), (NAN, 0.0, 0.0, 1.0), (1e6, 0.0, 0.0, 1.0), (0.9, 0.9, 0.9, 0.9))
    both = ((-1e8, 1e8, -1e8), (0.9, 0.9, 0.9, 0.9)), ((0.0, 0.0, 0.92), (-1.0, 0.0, 0.0, 0.0))
    for name in (HAND, ELBOW):
        one.ask(lambda s: s.change("autopilot", True))
        one.visitor.move_gizmo(name, phase="start")
        one.wait(lambda s: not s.settings.page.autopilot)
        for position, wxyz in (*((one, turn) for one in places), *((place, one) for one in turns), *both):
            one.visitor.move_gizmo(name, position, wxyz)
            roundtrip(one)
            one.run_on(0.1)
            held = one.ask(lambda s: s.held)
            assert (
                isinstance(held, HandTarget)
                and np.isfinite(held.position).all()
                and np.abs(held.position).max() <= 2.5
            )
            assert held.rotation is not None and np.allclose(held.rotation @ held.rotation.T, np.eye(3))
        one.ask(assert_sound)
        assert one.session.held is not None
        one.visitor.move_gizmo(name, phase="end")
        one.wait(lambda s: s.held is None)
    witness.run_on(0.05)
    assert witness.session.settings == first_settings({}, Settings())[0] and witness.session.held is None


def test_a_reset_during_a_drag_releases_the_handle(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house(), "autopilot=0&gizmo=1")
    one.visitor.move_gizmo(HAND, phase="start")
    one.visitor.move_gizmo(HAND, (0.4, -0.1, 1.1))
    one.run_on(0.3)
    press(one, "reset")
    assert one.ask(lambda s: s.held is None)
    home = one.ask(lambda s: s.simulation.kinematics.hand_pose(s.simulation.guided).translation.copy())
    one.visitor.wait_for(lambda v: np.linalg.norm(np.array(v.mirror.nodes[HAND]["position"]) - home) < 1e-3)
    # The button is still down: only the next press takes hold again.
    one.visitor.move_gizmo(HAND, (0.4, -0.1, 1.1))
    one.run_on(0.3)
    assert one.ask(lambda s: s.held is None)
    one.visitor.move_gizmo(HAND, phase="start")
    one.visitor.move_gizmo(HAND, (0.4, -0.1, 1.1))
    one.wait(lambda s: s.held is not None)


def test_a_slider_leads_the_master_and_the_slave_follows(house: OpenHouse, arrive: Arrive) -> None:
    guest = arrive(house(), "scene=master_slave&autopilot=0")
    session, visitor = guest.session, guest.visitor
    visitor.wait_for(lambda v: any(p.get("label") == "elbow" for p in v.mirror.gui.values()))
    master, slave = session.simulation.guided.joints, session.simulation.avoiding.joints
    before = session.simulation.positions.copy()
    wanted = float(np.degrees(before[master][3])) + 8.0
    for value in (float("nan"), 1e9, wanted):
        visitor.set_value("elbow", value)
    visitor.wait_for(lambda _: isinstance(session.held, JointTarget))
    visitor.wait_for(lambda _: abs(np.degrees(session.simulation.positions[master][3]) - wanted) < 0.5)
    visitor.wait_for(
        lambda _: abs(session.simulation.positions[slave][3] - before[slave][3]) > np.radians(4.0)
    )
    after = guest.ask(lambda s: s.simulation.positions.copy())
    assert np.abs(np.delete(after[master] - before[master], 3)).max() < 0.02
