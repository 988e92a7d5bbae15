"""A session at its start, on a machine on which no step and no action takes any time."""

import pytest

from app.session import session as session_module
from app.session.actions import ActionQueue
from app.session.session import Session
from app.settings import Settings
from scenes.settings import RunSettings

DT = RunSettings().dt


@pytest.fixture(autouse=True)
def fast_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(session_module, "perf_counter", lambda: 0.0)


@pytest.fixture
def session() -> Session:
    made = Session(Settings())
    made.posts = ActionQueue(made.handle, lambda: 0.0)
    return made


def bits(session: Session) -> bytes:
    return session.simulation.history.table().tobytes()


def go(session: Session, seconds: float) -> None:
    """Let a session run for so long, in frames of a tenth of a second."""
    for _ in range(round(seconds / 0.1)):
        session.advance(0.1)
