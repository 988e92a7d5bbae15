"""The stage of two arms: master and slave, and the ghost."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.app.conftest import HAND, Guest
from tests.app.page.helpers import press
from tests.app.stage.conftest import change, comes, drawn, hand, settle, visible


def test_the_master_is_led_and_the_slave_shows_where_it_ought_to_be(one: Guest) -> None:
    change(one, scene="master_slave", avoid="free", speed=2.0)
    assert not any(visible(one, name) for name in drawn(one.visitor) if name.startswith("/wish"))
    start = one.ask(hand)
    other = one.ask(lambda s: s.simulation.kinematics.hand_pose(s.simulation.avoiding).translation.copy())
    goal = start + 0.7 * (other - start)
    turn = one.visitor.mirror.nodes[HAND]["wxyz"]
    one.visitor.move_gizmo(HAND, phase="start")
    one.visitor.move_gizmo(HAND, tuple(goal.tolist()), turn)
    comes(one, lambda s: float(np.linalg.norm(hand(s) - goal)), 0.05)
    # The slave would mirror it into the master; it gives way, and how it ought to stand is drawn beside it.
    one.visitor.wait_for(lambda _: visible(one, "/wish/left/base"))
    assert "/wish/right/base" not in drawn(one.visitor)
    press(one, "pause")
    settle(one)
    desired = one.ask(lambda s: s.simulation.sample().desired[s.simulation.avoiding.joints].copy())
    node = "/wish/left/base"
    for i, angle in enumerate(desired):
        node += f"/j{i + 1}"
        actual = "/arms" + node[len("/wish") :]
        turned, real = (np.array(one.visitor.mirror.nodes[name]["wxyz"]) for name in (node, actual))
        q = one.ask(lambda s, i=i: float(s.simulation.positions[s.simulation.avoiding.joints][i]))
        between = 2.0 * math.acos(min(abs(float(turned @ real)), 1.0))
        assert between == pytest.approx(abs(angle - q), abs=1e-3)


def test_a_ghost_is_seen_where_it_differs_and_costs_nothing_when_off(one: Guest) -> None:
    press(one, "ghost")
    assert one.session.settings.page.ghost == "frozen" and one.session.ghost is not None
    one.run_on(0.2)
    # The same settings, the same posture: nothing to be seen.
    assert not any(name.startswith("/ghost") for name in drawn(one.visitor))
    change(one, law="unprotected", speed=2.0, autopilot=True)
    one.visitor.wait_for(lambda _: visible(one, "/ghost/left/base"))
    assert "/ghost/right/base" not in drawn(one.visitor)
    press(one, "ghost")
    assert one.session.settings.page.ghost == "off"
    one.visitor.wait_for(lambda v: not any(name.startswith("/ghost") for name in drawn(one.visitor)))
