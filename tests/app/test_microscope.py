"""The microscope: the largest jump of a run, its single steps, and the same inputs at half the time step."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.plots.microscope_chart import microscope_html
from app.session.microscope import STRIDE, Magnified
from app.session.session import Session
from app.settings import PageSettings, Settings
from scenes.history import COLUMN
from scenes.rerun import rerun
from scenes.settings import LawSettings, RunSettings
from scenes.single_steps import AROUND, avoiding_rates, largest_jump
from scenes.smoothness import ECHO
from tests.app.inline import Inline

SWITCHED = RunSettings(scene="ball", point="hand", law=LawSettings(law="strict_switched", pairs="single"))


@given(st.integers(2, 400), st.integers(1, 7), st.integers(0, 2**32 - 1))
def test_the_largest_jump_is_between_two_steps_that_count(steps: int, joints: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    times, velocities = np.linspace(0.0, (steps - 1) * 0.01, steps), rng.normal(size=(steps, joints))
    time = largest_jump(times, velocities, 0.01)
    jumps = np.abs(np.diff(velocities, axis=0)).max(axis=1)
    counted = [jump for jump, later in zip(jumps.tolist(), times[1:].tolist(), strict=True) if later >= ECHO * 0.01]
    if counted:
        assert jumps[int(np.searchsorted(times, time)) - 1] == max(counted)
    else:
        assert time == times[-1]


def looking(desk: Inline, settings: RunSettings = SWITCHED, seconds: float = 6.0) -> Session:
    session = Session(Settings(settings, PageSettings()), background=desk)
    while session.simulation.time < seconds:
        session.advance(0.1)
    session.toggle_pause()
    return session


def seen(session: Session, desk: Inline) -> Magnified:
    first = session.magnified
    assert first is not None and first.finer is None
    assert desk.work("microscope") == ["microscope"]
    second = session.magnified
    assert second is not None and second.finer is not None and second.time == first.time
    return second


@pytest.mark.usefixtures("fast_machine")
def test_what_is_seen_is_the_history_and_the_finer_steps_are_a_rerun() -> None:
    desk = Inline()
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
    recorded = session.recorded()
    assert recorded is not None
    again = rerun(recorded, substeps=2).table
    place = int(np.searchsorted(again[:, COLUMN["t"]], found.finer.times[0] - 1e-9))
    there = simulation.history.velocities(again)[place : place + len(found.finer.times), simulation.avoiding.joints]
    assert len(found.finer.times) == 4 * AROUND + 1 and found.finer.dt == pytest.approx(0.0025)
    assert found.finer.values.tobytes() == there[:, found.joint].tobytes()
    # A jump stays at half the step.
    assert found.finer.largest == pytest.approx(found.steps.largest, rel=0.1)
    # Nothing is asked a second time.
    assert session.magnified is not None and not desk.waiting("microscope")
    dots = re.findall(r'class="(\w+) dots" d="([^"]*)"', microscope_html(found, session.settings.run, 150))
    assert [(name, path.count("h0")) for name, path in dots] == [("u", 2 * AROUND + 1), ("ghost", 4 * AROUND + 1)]


@pytest.mark.usefixtures("fast_machine")
def test_another_signal_and_another_instant() -> None:
    desk = Inline()
    session = looking(desk, RunSettings(), 3.0)
    jump = seen(session, desk)
    for quantity in ("d", "lambda", "e"):
        session.microscope.look_at(quantity)
        found = session.magnified
        assert found is not None and found.finer is not None and found.time == jump.time
        table = session.simulation.history.table()
        at = int(np.searchsorted(table[:, COLUMN["t"]], found.steps.times[0]))
        column = np.sqrt(table[:, COLUMN["e2"]]) if quantity == "e" else table[:, COLUMN[quantity]]
        assert np.array_equal(found.steps.values, column[at : at + len(found.steps.values)])
    session.microscope.move(-STRIDE, 0.005)
    assert seen(session, desk).time == pytest.approx(jump.time - STRIDE * 0.005)
    session.microscope.find_jump()
    assert seen(session, desk).time == jump.time
    # At the newest step there is nothing after it yet; the finer steps are asked for again when there is.
    session.microscope.move(10_000, 0.005)
    newest = seen(session, desk)
    assert newest.time == newest.steps.times[-1]
    session.toggle_pause()
    session.advance(0.1)
    session.microscope.move(0, 0.005)
    session.advance(0.1)
    session.advance(0.1)
    assert session.magnified is not None and desk.waiting("microscope")
    session.reset()
    assert session.magnified is None and not desk.waiting("microscope") and session.microscope.span is None


@pytest.mark.usefixtures("fast_machine")
@pytest.mark.parametrize("time", [1.5, 20.0, 23.995])
def test_any_instant_of_the_run(time: float) -> None:
    desk = Inline()
    session = looking(desk, RunSettings(), 24.0)
    assert session.magnified is not None
    desk.work("microscope")
    session.microscope.go_to(time + 0.001)
    found = seen(session, desk)
    assert found.finer is not None and found.time == pytest.approx(time)
    table = session.simulation.history.table()
    near = np.abs(table[:, COLUMN["t"]] - time) < (AROUND + 0.5) * 0.005
    assert np.array_equal(found.steps.times, table[near, COLUMN["t"]])
    rates = avoiding_rates(session.simulation, table[near])
    assert np.array_equal(found.steps.values, rates[:, found.joint])
    # The finer steps meet the same stretch, and hardly differ where nothing jumps.
    assert found.finer.times[0] == pytest.approx(found.steps.times[0]) and len(found.finer.times) >= 2 * AROUND
    assert np.interp(found.steps.times, found.finer.times, found.finer.values) == pytest.approx(found.steps.values, abs=0.02)
    assert session.microscope.span == (table[0, COLUMN["t"]], table[-1, COLUMN["t"]], found.time)
    # A place before the run is its beginning.
    session.microscope.go_to(-5.0)
    assert (first := session.magnified) is not None and first.time == table[0, COLUMN["t"]]
