"""The microscope: single steps of a run, also at half the time step."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.features.studies.background_studies import BackgroundStudies
from app.features.studies.microscope import STRIDE, Magnified
from app.features.studies.microscope_chart import microscope_html
from app.session.session import Session
from app.settings import PageSettings, Settings
from scenes.history import COLUMN
from scenes.rerun import rerun
from scenes.settings import LawSettings, RunSettings
from scenes.smoothness import AROUND, ECHO, avoiding_rates, time_of_largest_jump
from tests.app.inline import Inline
from tests.app.session.conftest import go

SWITCHED = RunSettings(scene="ball", point="hand", law=LawSettings(law="strict_switched", pairs="single"))


@given(st.integers(2, 400), st.integers(1, 7), st.integers(0, 2**32 - 1))
def test_the_largest_jump_is_between_two_steps_that_count(steps: int, joints: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    times, velocities = np.linspace(0.0, (steps - 1) * 0.01, steps), rng.normal(size=(steps, joints))
    time = time_of_largest_jump(times, velocities, 0.01)
    jumps = np.abs(np.diff(velocities, axis=0)).max(axis=1)
    counted = [
        jump for jump, later in zip(jumps.tolist(), times[1:].tolist(), strict=True) if later >= ECHO * 0.01
    ]
    if counted:
        assert jumps[int(np.searchsorted(times, time)) - 1] == max(counted)
    else:
        assert time == times[-1]


def looking(desk: Inline, settings: RunSettings = SWITCHED, seconds: float = 6.0) -> Session:
    session = Session(Settings(settings, PageSettings()), background=desk)
    go(session, seconds)
    session.control.toggle_pause()
    return session


def seen(session: Session, desk: Inline) -> Magnified:
    first = session.parts.of(BackgroundStudies).microscope.magnify(session.simulation)
    assert first is not None and first.finer is None
    assert desk.work("microscope") == ["microscope"]
    second = session.parts.of(BackgroundStudies).microscope.magnify(session.simulation)
    assert second is not None and second.finer is not None and second.time == first.time
    return second


def test_the_steps_come_from_the_history_and_the_finer_ones_from_a_rerun(desk: Inline) -> None:
    session = looking(desk)
    found = seen(session, desk)
    assert found.finer is not None
    simulation, table = session.simulation, session.simulation.history.table()
    at = int(np.searchsorted(table[:, COLUMN["t"]], found.time))
    rows = slice(at - AROUND, at + AROUND + 1)
    rates = simulation.history.velocities(table)[:, simulation.avoiding.joints]
    assert found.steps.times.tobytes() == table[rows, COLUMN["t"]].tobytes()
    assert found.steps.values.tobytes() == rates[rows, found.joint].tobytes()
    jumps = np.abs(np.diff(rates, axis=0))[ECHO:]
    assert found.steps.largest == pytest.approx(jumps.max())
    recorded = session.inputs.window()
    assert recorded is not None
    again = rerun(recorded, substeps=2).table
    place = int(np.searchsorted(again[:, COLUMN["t"]], found.finer.times[0] - 1e-9))
    there = simulation.history.velocities(again)[
        place : place + len(found.finer.times), simulation.avoiding.joints
    ]
    assert len(found.finer.times) == 4 * AROUND + 1 and found.finer.dt == pytest.approx(0.0025)
    assert found.finer.values.tobytes() == there[:, found.joint].tobytes()
    # A jump keeps its size at half the step.
    assert found.finer.largest == pytest.approx(found.steps.largest, rel=0.1)
    # No job is started a second time.
    assert session.parts.of(BackgroundStudies).microscope.magnify(
        session.simulation
    ) is not None and not desk.waiting("microscope")
    dots = re.findall(r'class="(\w+) dots" d="([^"]*)"', microscope_html(found, session.settings.run, 150))
    assert [(name, path.count("h0")) for name, path in dots] == [
        ("u", 2 * AROUND + 1),
        ("ghost", 4 * AROUND + 1),
    ]


def test_after_a_change_of_the_time_step_the_finer_steps_match_the_shown_part(desk: Inline) -> None:
    session = looking(desk, RunSettings(dt=0.01), 2.0)
    session.control.toggle_pause()
    session.change("dt", 0.0025)
    go(session, 2.0)
    session.control.toggle_pause()
    session.parts.of(BackgroundStudies).microscope.go_to(3.0)
    found = seen(session, desk)
    assert found.finer is not None and len(found.finer.times) == 4 * AROUND + 1
    assert found.finer.times[[0, -1]] == pytest.approx(found.steps.times[[0, -1]])


def test_another_signal_and_another_moment(desk: Inline) -> None:
    session = looking(desk, RunSettings(), 3.0)
    jump = seen(session, desk)
    for quantity in ("d", "lambda", "e"):
        session.parts.of(BackgroundStudies).microscope.quantity = quantity
        found = session.parts.of(BackgroundStudies).microscope.magnify(session.simulation)
        assert found is not None and found.finer is not None and found.time == jump.time
        table = session.simulation.history.table()
        at = int(np.searchsorted(table[:, COLUMN["t"]], found.steps.times[0]))
        column = np.sqrt(table[:, COLUMN["e2"]]) if quantity == "e" else table[:, COLUMN[quantity]]
        assert np.array_equal(found.steps.values, column[at : at + len(found.steps.values)])
    session.parts.of(BackgroundStudies).microscope.move(-STRIDE, 0.005)
    assert seen(session, desk).time == pytest.approx(jump.time - STRIDE * 0.005)
    session.parts.of(BackgroundStudies).microscope.go_to(None)
    assert seen(session, desk).time == jump.time
    # The newest step has no successor yet; the finer steps are requested again when it has one.
    session.parts.of(BackgroundStudies).microscope.move(10_000, 0.005)
    newest = seen(session, desk)
    assert newest.time == newest.steps.times[-1]
    session.control.toggle_pause()
    session.advance(0.1)
    session.parts.of(BackgroundStudies).microscope.move(0, 0.005)
    session.advance(0.1)
    session.advance(0.1)
    assert session.parts.of(BackgroundStudies).microscope.magnify(
        session.simulation
    ) is not None and desk.waiting("microscope")
    session.reset()
    microscope = session.parts.of(BackgroundStudies).microscope
    assert microscope.magnify(session.simulation) is microscope.span is None
    assert not desk.waiting("microscope")


def test_any_moment_of_the_run(desk: Inline) -> None:
    session = looking(desk, RunSettings(), 24.0)
    microscope = session.parts.of(BackgroundStudies).microscope
    assert microscope.magnify(session.simulation) is not None
    desk.work("microscope")
    table = session.simulation.history.table()
    for time in (1.5, 20.0, 23.995):
        microscope.go_to(time + 0.001)
        found = seen(session, desk)
        assert found.finer is not None and found.time == pytest.approx(time)
        near = np.abs(table[:, COLUMN["t"]] - time) < (AROUND + 0.5) * 0.005
        assert np.array_equal(found.steps.times, table[near, COLUMN["t"]])
        rates = avoiding_rates(session.simulation, table[near])
        assert np.array_equal(found.steps.values, rates[:, found.joint])
        # The finer steps cover the same stretch and hardly differ without a jump.
        assert (
            found.finer.times[0] == pytest.approx(found.steps.times[0])
            and len(found.finer.times) >= 2 * AROUND
        )
        assert np.interp(found.steps.times, found.finer.times, found.finer.values) == pytest.approx(
            found.steps.values, abs=0.02
        )
        assert microscope.span == (table[0, COLUMN["t"]], table[-1, COLUMN["t"]], found.time)
    # A moment before the run gives its beginning.
    microscope.go_to(-5.0)
    assert (first := microscope.magnify(session.simulation)) is not None and first.time == table[
        0, COLUMN["t"]
    ]
