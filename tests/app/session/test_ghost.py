"""The ghost: a second run under the same hand."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.session.clock import BUDGET
from app.session.session import Session
from app.settings import PageSettings, Settings, ghosts
from scenes.experiments import EXPERIMENTS
from scenes.history import COLUMN
from scenes.laws import LAWS
from scenes.settings import RunSettings, values
from scenes.simulation import Simulation
from scenes.targets import HandTarget
from tests.app.session.conftest import go, slow_down

SCENES = tuple(EXPERIMENTS)


def at(scene: str = "hold", ghost: str = "off", **run: Any) -> Session:
    return Session(Settings(RunSettings(scene=scene, **run), PageSettings(ghost=ghost)))


def table(simulation: Simulation | None) -> np.ndarray:
    assert simulation is not None
    return simulation.history.table()


def the_ghost(session: Session) -> Simulation:
    assert session.ghost is not None
    return session.ghost


HAND = st.lists(st.floats(-0.5, 0.5), min_size=3, max_size=3).map(
    lambda way: HandTarget(np.array([0.3, 0.0, 1.0]) + way)
)
ACTIONS: st.SearchStrategy[Callable[[Session], object]] = st.one_of(
    st.floats(0.0, 0.1).map(lambda elapsed: lambda s: s.advance(elapsed)),
    HAND.map(lambda target: lambda s: s.hand.hold(target)),
    st.just(lambda s: s.hand.nudge(np.array([0.0, 0.02, 0.0]))),
    st.sampled_from(
        (
            lambda s: s.control.toggle_pause(),
            lambda s: s.control.single_step(),
            Session.reset,
            lambda s: s.hand.hold(None),
        )
    ),
    *(
        st.sampled_from(choices).map(lambda value, key=key: lambda s: s.change(key, value))
        for key, choices in {
            "dm": (0.1, 0.2),
            "k": (1.0, 4.0),
            "dt": (0.004, 0.008),
            "seed": (1, 2),
            "scene": SCENES,
            "rig": ("torso", "table"),
            "law": ("barrier_qp", "smooth_priority", "strict_switched"),
            "guided": ("left", "right"),
            "avoid": ("paper", "both", "guided"),
            "coupled": (True, False),
            "autopilot": (True, False),
        }.items()
    ),
)
GHOSTS = st.none() | st.sampled_from(tuple(ghosts()))


@pytest.mark.thorough
@settings(max_examples=40)
@given(st.lists(st.tuples(ACTIONS, GHOSTS), min_size=5, max_size=25))
def test_a_ghost_never_changes_the_run_for_any_actions(actions: list[tuple[Any, Any]]) -> None:
    alone, haunted = at(), at()
    for action, new in actions:
        if new is not None:
            haunted.change("ghost", new)
        for session in (alone, haunted):
            action(session)
            session.advance(0.06)
        ghost = haunted.ghost
        if ghost is not None:
            assert (ghost.steps, ghost.time) == (haunted.simulation.steps, haunted.simulation.time)
            assert ghost.room is haunted.simulation.room and np.isfinite(ghost.positions).all()
    assert table(alone.simulation).tobytes() == table(haunted.simulation).tobytes()
    assert replace(haunted.settings, page=alone.settings.page) == alone.settings


@pytest.mark.parametrize("scene", SCENES)
def test_a_ghost_with_the_same_settings_equals_the_run_in_any_scene(scene: str) -> None:
    session = at(scene, ball="cross")
    go(session, 1.0)
    session.change("ghost", "frozen")
    go(session, 1.0)
    session.hand.hold(HandTarget(np.array([0.4, 0.1, 1.0])))
    go(session, 0.5)
    ghost = table(session.ghost)
    assert len(ghost) == 300 and ghost.tobytes() == table(session.simulation)[-300:].tobytes()
    # Also from the first step on, as after a link.
    session = at(scene, "frozen", ball="cross")
    assert the_ghost(session).settings == session.settings.run
    go(session, 0.5)
    assert table(session.ghost).tobytes() == table(session.simulation).tobytes()


def test_a_frozen_ghost_keeps_law_and_gain_and_others_follow_the_run() -> None:
    session = at()
    session.change("dm", 0.12)
    session.change("k", 3.0)
    session.change("ghost", "frozen")
    frozen = session.settings.run
    changes = {
        "dm": 0.25,
        "law": "unprotected",
        "pairs": "single",
        "k": 1.0,
        "gamma": 7.0,
        "wmax": 0.4,
        "dt": 0.004,
    }
    for key, value in changes.items():
        session.change(key, value)
        assert the_ghost(session).settings == replace(session.settings.run, law=frozen.law, gain=3.0)
    go(session, 1.0)
    assert the_ghost(session).law.activation(0.13) < 1.0 == the_ghost(session).law.activation(0.12)
    # A new choice freezes the present settings.
    session.change("ghost", "off")
    assert session.ghost is None
    session.change("ghost", "frozen")
    assert the_ghost(session).settings == session.settings.run
    for law in LAWS:
        session.change("ghost", law)
        session.change("dm", session.settings.run.law.critical_distance - 0.01)
        assert the_ghost(session).settings == replace(
            session.settings.run, law=replace(session.settings.run.law, law=law)
        )


def test_a_ghost_begins_at_the_runs_state_and_follows_the_same_hand() -> None:
    session = at(ghost="unprotected")
    go(session, 6.0)
    simulation = session.simulation
    other, joints = simulation.avoiding.joints, simulation.guided.joints
    assert np.abs(the_ghost(session).positions[other] - simulation.positions[other]).max() > 0.01
    assert the_ghost(session).positions[joints].tobytes() == simulation.positions[joints].tobytes()
    session.change("ghost", "barrier_qp")
    ghost = the_ghost(session)
    assert ghost.positions.tobytes() == simulation.positions.tobytes()
    assert (ghost.time, ghost.steps, ghost.history.count) == (simulation.time, simulation.steps, 0)
    go(session, 0.1)
    rows = table(ghost)
    assert rows[:, COLUMN["t"]].tobytes() == table(simulation)[-len(rows) :, COLUMN["t"]].tobytes()


def test_reset_resets_both() -> None:
    session = at(ghost="frozen")
    session.change("dm", 0.25)
    go(session, 1.0)
    session.reset()
    ghost = the_ghost(session)
    assert (ghost.time, ghost.steps, ghost.history.count) == (0.0, 0, 0)
    assert ghost.positions.tobytes() == session.simulation.positions.tobytes()
    assert ghost.settings.law.critical_distance == 0.15
    go(session, 1.0)
    fresh = at(dt=ghost.settings.dt)
    go(fresh, 1.0)
    assert table(ghost).tobytes() == table(fresh.simulation).tobytes()


@pytest.mark.parametrize(
    "change", ["scene=master_slave", "rig=table", "guided=left", "scene=ball", "scene=solo"]
)
def test_another_room_or_role_has_a_new_ghost(change: str) -> None:
    session = at(ghost="unprotected")
    go(session, 6.0)
    old = the_ghost(session)
    session.change(*change.split("="))
    ghost, simulation = the_ghost(session), session.simulation
    assert ghost is not old and ghost.room is simulation.room and ghost.settings.law.law == "unprotected"
    assert ghost.positions.tobytes() == simulation.positions.tobytes() and ghost.time == simulation.time
    assert ghost.guided == simulation.guided
    go(session, 0.5)
    assert ghost.history.count == 100


def test_a_slow_machine_slows_run_and_ghost_together(monkeypatch: pytest.MonkeyPatch) -> None:
    session = at(ghost="barrier_qp")
    ghost = the_ghost(session)
    slow_down(monkeypatch, ghost, [BUDGET / 2.0])
    made = [session.advance(0.08) for _ in range(20)]
    assert all(0 < count < 16 for count in made) and session.pace.slowed
    assert ghost.steps == session.simulation.steps == sum(made)
    assert np.allclose(np.diff(table(ghost)[:, 0]), values(session.settings)["dt"])
