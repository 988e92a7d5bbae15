"""An endless loop is told from a machine that has other things to do."""

from __future__ import annotations

import os
import sys

import pytest

from app.custom_law import patience as patience_module
from app.custom_law.patience import LONGEST, Patience


class Machine:
    """Clocks that stand still until they are moved."""

    def __init__(self) -> None:
        self.now = 0.0
        self.used: float | None = 0.0
        self.wants = True


@pytest.fixture
def machine(monkeypatch: pytest.MonkeyPatch) -> Machine:
    """What `Patience` sees instead of the real one."""
    machine = Machine()
    monkeypatch.setattr(patience_module.time, "monotonic", lambda: machine.now)
    monkeypatch.setattr(patience_module, "_used", lambda process: machine.used)
    monkeypatch.setattr(patience_module, "_wants_a_core", lambda process: machine.wants)
    return machine


def test_time_limits_on_a_busy_machine(machine: Machine) -> None:
    # A process that computes or sleeps is too long.
    for used, wants in ((1.1, True), (0.0, False), (None, True)):
        machine.now, machine.used = 0.0, None if used is None else 0.0
        patience = Patience(1, 1.0)
        machine.now, machine.used, machine.wants = 0.99, used, wants
        assert not patience.over
        machine.now = 1.01
        assert patience.over
    # A process that waits for a core is given time, but not for ever.
    machine.now, machine.used, machine.wants = 0.0, 0.0, True
    patience = Patience(1, 1.0)
    machine.now, machine.used = LONGEST - 0.1, 0.9
    assert not patience.over
    machine.now = LONGEST + 0.1
    assert patience.over


@pytest.mark.skipif(sys.platform != "linux", reason="only there it is known")
def test_this_process_by_its_own_number() -> None:
    """It runs, uses time, and what is no process neither runs nor does."""
    before = patience_module._used(os.getpid())
    assert before is not None and before > 0.0
    sum(range(1_000_000))
    after = patience_module._used(os.getpid())
    assert after is not None and after > before
    assert patience_module._wants_a_core(os.getpid())
    gone = 2**22 + 1
    assert patience_module._used(gone) is None and not patience_module._wants_a_core(gone)
