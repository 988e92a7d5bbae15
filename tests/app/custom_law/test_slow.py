"""A law that is slow, or hangs, holds up nothing but the run that it moves, and the page says so."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pytest

from app.custom_law.custom_law import MOST, CustomLaw
from app.custom_law.process import LawProcess
from app.custom_law.time_share import SHARE, LawTimeShare
from app.custom_law.wire import Numbers, Question
from app.page.panels.readout import custom_law_html, status_html
from app.session.input_sources import InputSources
from app.session.session import Session
from app.settings import Settings
from scenes.headless import run
from scenes.settings import changed
from tests.app.custom_law.helpers import PAPER, until, write

FRAME = 0.03


def gated(gate: Path) -> str:
    """The paper's law, which from its tenth call on waits for a file, and counts its calls in what it returns."""
    return f"""
        import pathlib, time
        calls = 0
        D_M, ORDER, V, MU = 0.15, 6.0, 0.30, 0.06

        def activation(distance):
            return 1.0 if distance <= D_M else (D_M / distance) ** ORDER

        def law(situation):
            global calls
            calls += 1
            while calls == 10 and not pathlib.Path({str(gate)!r}).exists():
                time.sleep(0.001)
            c = activation(situation.distance) * (V + situation.pull)
            J_d = situation.row
            return situation.nominal + J_d * c / (J_d @ J_d + MU**2) + 1e-9 * calls
    """


@contextmanager
def sessions(path: Path, count: int = 1, **settings: object) -> Iterator[list[Session]]:
    """Sessions of a server that has a law file."""
    given, people = Settings(), InputSources(law_file=path)
    for key, value in settings.items():
        given = changed(given, key, value)
    with ExitStack() as stack:
        made = [Session(given, sources=people) for _ in range(count)]
        for session in made:
            stack.callback(session.close)
        yield made


def advanced(session: Session, true: Callable[[], object]) -> None:
    """Advance until something is true."""
    until(lambda: session.advance(FRAME) < 0 or true())


def hangs(session: Session) -> bool:
    """Whether the session's run has begun, and waits."""
    return session.simulation.steps > 0 and session.student_law.waits


def patient(session: Session, limit: float = 60.0) -> None:
    """Let one call of a session's law take longer than usual."""
    law = session.law._law
    assert law is not None
    object.__setattr__(law.limits, "call", limit)


@pytest.mark.parametrize("scene", ["hold", "ball", "imitation"])
def test_a_run_waits_for_its_law_and_comes_out_the_same(file: Path, tmp_path: Path, scene: str) -> None:
    """While a call hangs no step is made, and nothing is asked twice; the run has the bits of one that waited for every call."""
    gate = tmp_path / "go on"
    write(file, gated(gate))
    with sessions(file, scene=scene, avoid="both" if scene == "imitation" else "free") as (session,):
        patient(session)
        advanced(session, lambda: hangs(session))
        steps, before = session.simulation.steps, session.simulation.snapshot()
        assert 0 < steps < 10
        for _ in range(20):
            assert session.advance(FRAME) == 0
        after = session.simulation.snapshot()
        assert session.simulation.steps == steps and after.velocities.tobytes() == before.velocities.tobytes()
        for one, other in zip(before.memories, after.memories, strict=True):
            assert [array.tobytes() for array in one] == [array.tobytes() for array in other]
        assert "waiting for my_law.py" in custom_law_html(session.student_law) and not session.pace.slowed
        advanced(session, lambda: session.pace.rate < 0.01)
        gate.touch()
        advanced(session, lambda: session.simulation.steps >= 60)
        assert "runs my_law.py" in custom_law_html(session.student_law)
        recorded, made = session.recorded(), session.simulation.steps
        assert recorded is not None and recorded.steps == made
        with CustomLaw(file, waits=True) as law:
            reference = run(session.settings.run, made * session.settings.run.dt, law=law)
        assert session.simulation.history.table().tobytes() == reference.table.tobytes()


def test_a_step_that_is_asked_for_while_paused_is_made_when_the_law_answers(file: Path, tmp_path: Path) -> None:
    gate = tmp_path / "go on"
    write(file, gated(gate))
    with sessions(file) as (session,):
        patient(session)
        advanced(session, lambda: hangs(session))
        steps = session.simulation.steps
        session.single_step()
        for _ in range(5):
            assert session.advance(FRAME) == 0
        gate.touch()
        advanced(session, lambda: session.simulation.steps > steps)
        assert session.simulation.steps == steps + 1 and session.advance(FRAME) == 0


def test_a_ghost_that_is_waited_for_keeps_the_run_beside_it(file: Path, tmp_path: Path) -> None:
    """Both stand still; what is recorded makes the run again to the last bit."""
    from scenes.rerun import rerun

    gate = tmp_path / "go on"
    write(file, gated(gate))
    with sessions(file, ghost="own") as (session,):
        patient(session)
        advanced(session, lambda: hangs(session))
        assert session.ghost is not None and session.ghost.steps == session.simulation.steps
        session.change("n", 8.0)
        assert session.advance(FRAME) == 0
        gate.touch()
        advanced(session, lambda: session.simulation.steps >= 60)
        assert session.ghost.steps == session.simulation.steps
        recorded = session.recorded()
        assert recorded is not None and recorded.snapshot.steps == 0
        assert rerun(recorded).table.tobytes() == session.simulation.history.table().tobytes()


def test_a_frame_waits_no_longer_than_its_share(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Once, when a call is not answered; in the frames after that it is not waited for at all, and nor is a chart."""
    in_vain: list[float] = []
    answer = LawProcess.answer

    def noted(process: LawProcess, seconds: float) -> tuple[Question, Numbers] | None:
        news = answer(process, seconds)
        if news is None:
            in_vain.append(seconds)
        return news

    monkeypatch.setattr(LawProcess, "answer", noted)
    write(file, gated(tmp_path / "never"))
    with sessions(file) as (session,):
        patient(session)
        advanced(session, lambda: in_vain.clear() or session.simulation.steps > 0)
        while not hangs(session):
            in_vain.clear()
            session.advance(FRAME)
            assert sum(in_vain) <= MOST
        in_vain.clear()
        session.advance(FRAME)
        law = session.law._law
        assert law is not None
        assert np.isnan(law.line_rates(np.linspace(0.0, 0.6, 50), 0.1, 0.0, 1.0)).all()
        assert in_vain and sum(in_vain) == 0.0


def test_a_share_is_divided_among_those_who_call(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 0.0
    monkeypatch.setattr("app.custom_law.time_share.monotonic", lambda: now)
    share = LawTimeShare()
    assert share.part(1) == SHARE and share.part(2) == SHARE / 2 and share.part(1) == SHARE / 2
    now = 1.0
    assert share.part(1) == SHARE


def test_the_page_names_the_law_and_not_the_computer(file: Path) -> None:
    """With the time that a call takes, and the time that it may take."""
    write(file, "import time\n" + "\n".join(line[4:] for line in PAPER.splitlines()).replace("c =", "time.sleep(0.01); c ="))
    with sessions(file, 1, scene="ball", dt=0.005) as (session,):
        advanced(session, lambda: session.student_law.slow is not None)
        assert session.student_law.slow is not None
        needs, allowed = session.student_law.slow
        assert needs >= 0.01 and allowed == pytest.approx(SHARE * 0.005)
        said = custom_law_html(session.student_law)
        assert f"slowed: your law needs {1e3 * needs:.2g} ms a call; real time allows 2 ms" in said
        assert "machine" not in status_html(session.pace, session.simulation, session.simulation.sample())
        session.toggle_pause()
        assert "runs my_law.py" in custom_law_html(session.student_law)
        session.toggle_pause()
        write(file, "def law(s): return None")
        advanced(session, lambda: session.student_law.problem)
        assert not session.pace.slowed
        write(file, PAPER)
        advanced(session, lambda: session.student_law.slow is None and not session.student_law.problem)


def test_a_curve_of_the_law_is_there_a_moment_later(file: Path) -> None:
    """Without waiting: blank until the answer is there, and blank where the function fails."""
    write(file, PAPER.replace("1.0 if distance <= D_M", "1 / 0 if distance == 0.0 else 1.0 if distance <= D_M"))
    with sessions(file) as (session,):
        law = session.law._law
        assert law is not None
        distances = np.array([0.0, 0.1, 0.3])
        assert np.isnan(law.activations(distances)).all()
        until(lambda: session.advance(FRAME) < 0 or np.isfinite(law.activations(distances)).any())
        np.testing.assert_allclose(law.activations(distances), [np.nan, 1.0, 0.5**6])
        assert law.problem is None
