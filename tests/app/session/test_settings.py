"""A change of settings moves nothing by itself and acts in the next step; an impossible one leaves everything."""

import math
from typing import Any

import numpy as np
import pytest

from app.session import session as session_module
from app.session.session import Session
from controllers.errors import BadSetting
from scenes.room import Room
from scenes.settings import RunSettings, values
from scenes.targets import HandTarget
from tests.app.page.helpers import SPECS, another
from tests.app.session.conftest import DT


@pytest.mark.parametrize("key", [key for key in SPECS if key not in ("scene", "rig", "robot")])
def test_a_change_moves_nothing_by_itself(session: Session, key: str) -> None:
    for _ in range(30):
        session.advance(0.1)
    simulation, before = session.simulation, session.simulation.positions.copy()
    present, steps = values(session.settings), simulation.steps
    session.change(key, another(key, present[key])[1])
    after = values(session.settings)
    assert [k for k in present if present[k] != after[k]] == [key]
    assert simulation.positions.tobytes() == before.tobytes() and simulation.steps == steps
    assert simulation.settings == session.settings.run
    # And no jump afterwards either.
    session.advance(0.05)
    assert simulation.steps > steps
    moves = np.abs(np.diff(simulation.history.positions(simulation.history.table()), axis=0))
    assert (moves <= simulation.room.model.velocityLimit * 0.02 + 1e-12).all()


def test_a_change_acts_in_the_next_step(session: Session) -> None:
    session.advance(0.05)
    assert session.simulation.sample().activation < 0.9
    session.change("dm", 0.30)
    session.advance(DT)
    law, sample = session.simulation.law, session.simulation.sample()
    assert sample.activation == law.activation(sample.law_distance)
    assert law.activation(0.29) == 1.0


def test_another_rig_is_a_fresh_start_there(session: Session) -> None:
    session.advance(0.1)
    session.hold(HandTarget(np.zeros(3)))
    session.change("rig", "table")
    assert session.held is None and session.simulation.steps == 0
    assert session.simulation.positions.tobytes() == Session(session.settings).simulation.positions.tobytes()


def test_a_robot_that_is_not_there_changes_nothing(session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(settings: RunSettings) -> Room:
        raise BadSetting(f"{settings.robot} needs a package that is not installed.")

    session.advance(0.1)
    session.hold(HandTarget(np.array([0.4, 0.1, 1.0])))
    before, room = session.settings, session.simulation.room
    monkeypatch.setattr(session_module, "room_of", missing)
    with pytest.raises(BadSetting, match="panda needs"):
        session.change("robot", "panda")
    assert session.settings is before and session.simulation.settings is before.run and session.simulation.room is room
    assert session.held is not None
    assert session.advance(0.1) == 20


@pytest.mark.parametrize("key", [*SPECS, "nothing"])
def test_an_impossible_value_leaves_everything(session: Session, key: str) -> None:
    before, spec = session.settings, SPECS.get(key)
    bad: list[Any] = [math.nan, None, [], "nonsense", *([1.5] if key == "seed" else [])]
    if spec is not None and math.isfinite(spec.low):
        bad += [math.inf, -math.inf, 1e9, -1e9, True, spec.high + 0.5, spec.low - 0.5]
    for value in bad:
        with pytest.raises(BadSetting, match=key):
            session.change(key, value)
        assert session.settings is before and session.simulation.settings is before.run, value
