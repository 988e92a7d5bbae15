"""A machine on which steps take no time, and jobs that finish on a test's request."""

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
