"""A session at its start, on a machine with instant steps and actions, or with a given step time."""

from typing import Any

import pytest

from app.session import run_control
from app.session.actions import ActionQueue
from app.session.session import Session
from app.settings import Settings
from scenes.settings import RunSettings
from scenes.simulation import Simulation
from tests.app.inline import Inline

DT = RunSettings().dt


@pytest.fixture(autouse=True)
def fast_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_control, "perf_counter", lambda: 0.0)


@pytest.fixture
def desk() -> Inline:
    return Inline()


@pytest.fixture
def session() -> Session:
    made = Session(Settings())
    made.posts = ActionQueue(made.handlers.do, lambda: 0.0)
    return made


def slow_down(monkeypatch: pytest.MonkeyPatch, simulation: Simulation, cost: list[float]) -> None:
    """From now on a step of this simulation takes `cost[0]` [s]; nothing else takes time."""
    clock, step = [0.0], simulation.step

    def slow(target: Any) -> None:
        clock[0] += cost[0]
        step(target)

    monkeypatch.setattr(run_control, "perf_counter", lambda: clock[0])
    monkeypatch.setattr(simulation, "step", slow)


def bits(session: Session) -> bytes:
    return session.simulation.history.table().tobytes()


def go(session: Session, seconds: float) -> None:
    """Advance a session by `seconds` in frames of 0.1 s."""
    for _ in range(round(seconds / 0.1)):
        session.advance(0.1)
