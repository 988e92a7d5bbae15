"""A session at its start, on a machine on which no step takes any time."""

import pytest

from app.session import session as session_module
from app.session.session import Session
from app.settings import Settings
from scenes.settings import RunSettings

DT = RunSettings().dt


@pytest.fixture(autouse=True)
def fast_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(session_module, "perf_counter", lambda: 0.0)


@pytest.fixture
def session() -> Session:
    return Session(Settings())


def bits(session: Session) -> bytes:
    return session.simulation.history.table().tobytes()
