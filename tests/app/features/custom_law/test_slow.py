"""A slow or hanging law delays only its run, and the page says so; a busy machine is not an endless loop."""

import os
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from app.features.custom_law import law_limits
from app.features.custom_law.custom_law import MOST, CustomLaw
from app.features.custom_law.law_limits import LONGEST, SHARE, LawTimeShare, Patience
from app.features.custom_law.process import LawProcess
from app.features.custom_law.student_law import student_law
from app.features.custom_law.wire import LawQuestion, Numbers
from app.page.panels.readout import late_law_html, status_html
from app.session.late_law import LateLawStatus
from app.session.session import Session
from scenes.headless import run
from scenes.rerun import rerun
from tests.app.features.custom_law.helpers import PAPER, session_of, write
from tests.app.runtime.processes import until

FRAME = 0.03


def gated(gate: Path) -> str:
    """The paper's law: its tenth call waits for a file; its result encodes the number of calls."""
    waits = f"""
        global calls
        calls += 1
        while calls == 10 and not pathlib.Path({str(gate)!r}).exists():
            time.sleep(0.001)
        c ="""
    counted = PAPER.replace("\n        c =", waits).replace("MU**2)", "MU**2) + 1e-9 * calls")
    return f"    import pathlib, time\n    calls = 0\n{counted}"


def advanced(session: Session, true: Callable[[], object]) -> None:
    until(lambda: session.advance(FRAME) < 0 or true())


def hangs(session: Session) -> bool:
    return session.simulation.steps > 0 and session.law_status.waits


def patient(session: Session, limit: float = 60.0) -> None:
    law = student_law(session).law
    assert isinstance(law, CustomLaw)
    law.limits = replace(law.limits, call=limit)


@pytest.mark.parametrize("scene", ["ball", "imitation"])
def test_a_run_waits_for_its_law_and_gives_the_same_result(file: Path, tmp_path: Path, scene: str) -> None:
    gate = tmp_path / "go on"
    write(file, gated(gate))
    with session_of(file, scene=scene, avoid="both" if scene == "imitation" else "free") as session:
        patient(session)
        # Hanging at the tenth call; any law may be late for a moment before that.
        whole = 9 // (2 if scene == "imitation" else 1)
        advanced(session, lambda: hangs(session) and session.simulation.steps == whole)
        steps, before = session.simulation.steps, session.simulation.snapshot()
        for _ in range(20):
            assert session.advance(FRAME) == 0
        after = session.simulation.snapshot()
        assert session.simulation.steps == steps and after.velocities.tobytes() == before.velocities.tobytes()
        for one, other in zip(before.memories, after.memories, strict=True):
            assert [array.tobytes() for array in one] == [array.tobytes() for array in other]
        assert "waiting for my_law.py" in late_law_html(session.law_status) and not session.pace.slowed
        advanced(session, lambda: session.pace.rate < 0.01)
        # A step requested during the wait is made when the law answers.
        session.control.single_step()
        for _ in range(5):
            assert session.advance(FRAME) == 0
        gate.touch()
        advanced(session, lambda: session.simulation.steps > steps)
        assert session.simulation.steps == steps + 1 and session.advance(FRAME) == 0
        session.control.toggle_pause()
        # The slow tenth call is still in the average.
        advanced(
            session,
            lambda: session.simulation.steps >= 60 and "runs my_law.py" in late_law_html(session.law_status),
        )
        recorded, made = session.inputs.window(), session.simulation.steps
        assert recorded is not None and recorded.steps == made
        with CustomLaw(file, waits=True) as law:
            reference = run(session.settings.run, made * session.settings.run.dt, law=law)
        assert session.simulation.history.table().tobytes() == reference.table.tobytes()
        assert rerun(recorded).table.tobytes() == reference.table.tobytes()


def test_the_run_waits_with_a_waiting_ghost(file: Path, tmp_path: Path) -> None:
    gate = tmp_path / "go on"
    write(file, gated(gate))
    with session_of(file, ghost="own") as session:
        patient(session)
        # Hanging at the tenth call, as above.
        advanced(session, lambda: hangs(session) and session.simulation.steps == 9)
        assert session.ghost is not None and session.ghost.steps == session.simulation.steps
        session.change("n", 8.0)
        assert session.advance(FRAME) == 0
        gate.touch()
        advanced(session, lambda: session.simulation.steps >= 60)
        assert session.ghost.steps == session.simulation.steps
        recorded = session.inputs.window()
        assert recorded is not None and recorded.snapshot.steps == 0
        assert rerun(recorded).table.tobytes() == session.simulation.history.table().tobytes()


def test_a_frame_waits_no_longer_than_its_share(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    in_vain: list[float] = []
    answer = LawProcess.answer

    def noted(process: LawProcess, seconds: float) -> tuple[LawQuestion, Numbers] | None:
        news = answer(process, seconds)
        if news is None:
            in_vain.append(seconds)
        return news

    monkeypatch.setattr(LawProcess, "answer", noted)
    write(file, gated(tmp_path / "never"))
    with session_of(file) as session:
        patient(session)
        advanced(session, lambda: in_vain.clear() or session.simulation.steps > 0)
        # Hanging at the tenth call, as above.
        while not (hangs(session) and session.simulation.steps == 9):
            in_vain.clear()
            session.advance(FRAME)
            assert sum(in_vain) <= MOST
        in_vain.clear()
        session.advance(FRAME)
        law = student_law(session).law
        assert isinstance(law, CustomLaw)
        assert np.isnan(law.line_rates(np.linspace(0.0, 0.6, 50), 0.1, 0.0, 1.0)).all()
        assert in_vain and sum(in_vain) == 0.0


def test_the_share_is_divided_among_all_callers(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 0.0
    monkeypatch.setattr("app.features.custom_law.law_limits.time.monotonic", lambda: now)
    share = LawTimeShare()
    assert share.part(1) == SHARE and share.part(2) == SHARE / 2 and share.part(1) == SHARE / 2
    now = 1.0
    assert share.part(1) == SHARE


def test_the_page_blames_the_law_and_not_the_computer(file: Path) -> None:
    write(
        file,
        "import time\n"
        + "\n".join(line[4:] for line in PAPER.splitlines()).replace("c =", "time.sleep(0.01); c ="),
    )
    with session_of(file, scene="ball", dt=0.005) as session:
        # On a busy machine it sleeps longer than a call may take.
        patient(session)
        found: list[LateLawStatus] = []

        def is_slow() -> bool:
            found[:] = [session.law_status]
            # The session may wait for it a moment later.
            return found[0].slow is not None and not found[0].waits

        advanced(session, is_slow)
        (status,) = found
        assert status.slow is not None
        needs, allowed = status.slow
        assert needs >= 0.01 and allowed == pytest.approx(SHARE * 0.005)
        said = late_law_html(status)
        assert (
            f"slowed: your law needs {1e3 * needs:.2g}\N{NO-BREAK SPACE}ms a call; real time allows 2\N{NO-BREAK SPACE}ms"
            in said
        )
        assert "machine" not in status_html(session.pace, session.simulation, session.simulation.sample())
        session.control.toggle_pause()
        advanced(session, lambda: "runs my_law.py" in late_law_html(session.law_status))
        session.control.toggle_pause()
        write(file, "def law(s): return None")
        advanced(session, lambda: session.law_status.problem)
        assert not session.pace.slowed
        write(file, PAPER)
        advanced(session, lambda: session.law_status.slow is None and not session.law_status.problem)


def test_a_curve_of_the_law_appears_after_a_moment(file: Path) -> None:
    write(
        file, PAPER.replace("1.0 if distance <= D_M", "1 / 0 if distance == 0.0 else 1.0 if distance <= D_M")
    )
    with session_of(file) as session:
        law = student_law(session).law
        assert isinstance(law, CustomLaw)
        distances = np.array([0.0, 0.1, 0.3])
        assert np.isnan(law.activations(distances)).all()
        until(lambda: session.advance(FRAME) < 0 or np.isfinite(law.activations(distances)).any())
        np.testing.assert_allclose(law.activations(distances), [np.nan, 1.0, 0.5**6])
        assert law.problem is None


def test_time_limits_on_a_busy_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    machine = SimpleNamespace(now=0.0, used=0.0, wants=True, without_core=0.0)
    monkeypatch.setattr(law_limits.time, "monotonic", lambda: machine.now)
    monkeypatch.setattr(law_limits, "processor_time", lambda process: machine.used)
    monkeypatch.setattr(law_limits, "wants_a_core", lambda process: machine.wants)
    monkeypatch.setattr(law_limits, "without_core", lambda process: machine.without_core)
    # A process that computes or sleeps exceeds the limit.
    for used, wants in ((1.1, True), (0.0, False), (None, True)):
        machine.now, machine.used = 0.0, None if used is None else 0.0
        patience = Patience(1, 1.0)
        machine.now, machine.used, machine.wants = 0.99, used, wants
        assert not patience.over
        machine.now = 1.01
        assert patience.over
    # A process that waits for a core gets more time, up to `LONGEST`.
    machine.now, machine.used, machine.wants = 0.0, 0.0, True
    patience = Patience(1, 1.0)
    machine.now, machine.used = LONGEST - 0.1, 0.9
    assert not patience.over
    machine.now = LONGEST + 0.1
    assert patience.over
    # A process that has waited for a core and now sleeps began late.
    machine.now, machine.used, machine.wants, machine.without_core = 0.0, 0.0, False, 3.0
    patience = Patience(1, 1.0)
    machine.now, machine.without_core = 1.4, 3.5
    assert not patience.over
    machine.now = 1.6
    assert patience.over


@pytest.mark.skipif(sys.platform != "linux", reason="only there it is known")
def test_processor_time_of_this_process_and_of_a_missing_one() -> None:
    before = law_limits.processor_time(os.getpid())
    assert before is not None and before > 0.0
    sum(range(1_000_000))
    after = law_limits.processor_time(os.getpid())
    assert after is not None and after > before
    assert law_limits.wants_a_core(os.getpid())
    gone = 2**22 + 1
    assert law_limits.processor_time(gone) is None and not law_limits.wants_a_core(gone)
