"""A machine on which no step takes any time, and jobs that are done when a test says so."""

import pytest

from app.session import run_control
from tests.app.inline import Inline


@pytest.fixture(autouse=True)
def fast_machine(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if "desk" in request.fixturenames:
        monkeypatch.setattr(run_control, "perf_counter", lambda: 0.0)


@pytest.fixture
def desk() -> Inline:
    return Inline()
