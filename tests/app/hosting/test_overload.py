"""Under overload all pages get equally fewer frames and time slows down; admission follows the capacity."""

import itertools
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Callable
from time import perf_counter
from typing import Any

import pytest

from app.hosting import workload
from app.hosting.frame_loop import FrameLoop
from app.hosting.workload import BAND, ENOUGH, Workload, affordable, places, step_seconds
from app.page.operation import CALM
from app.page.panels.controls import Controls
from app.page.panels.server_load import ServerLoad, load_pills
from app.session import run_control
from app.session.actions import SetSetting
from app.session.clock import FRAME, LEAST, SLOWEST
from app.session.session import Session
from app.settings import Settings
from controllers.compiled import GAIN
from tests.app.conftest import Arrive, ByHand, Made, OpenHouse, live_sessions, private_of
from tests.app.page.helpers import shown

STEP = 200e-6
"""Time of a step on the tests' machine [s]; drawing takes no time by default."""


class Machine:
    """A machine with its own clock that runs sessions; steps and drawing take the given times."""

    def __init__(
        self, monkeypatch: pytest.MonkeyPatch, sessions: int, drawing: float, step: float = STEP
    ) -> None:
        self.now, self.drawing = 0.0, drawing
        self.workload = Workload(sessions)
        self.sessions = [Session(Settings()) for _ in range(sessions)]
        self.counts = [0] * sessions
        self.begins: list[float] = []
        monkeypatch.setattr(run_control, "perf_counter", lambda: self.now)
        for session in self.sessions:
            monkeypatch.setattr(session.simulation, "step", self._taking(step, session.simulation.step))
        self.loop = FrameLoop(self.frame, threading.Event(), self.workload.note, lambda: self.now)

    def _taking(self, seconds: float, step: Callable[[Any], None]) -> Callable[[Any], None]:
        def slow(target: Any) -> None:
            self.now += seconds
            step(target)

        return slow

    def frame(self, now: float, elapsed: float) -> None:
        self.begins.append(now)
        for number, session in enumerate(self.sessions):
            session.advance(elapsed, self.workload.budget)
            self.workload.drew(session.control.stepping)
            self.now += self.drawing
            self.counts[number] += 1

    def run(self, seconds: float) -> float:
        """Run for `seconds`. Return the frames per second."""
        end, before, begin = self.now + seconds, len(self.begins), self.now
        while self.now < end:
            soonest, beat = self.loop.round()
            self.now = max(self.now, soonest, beat)
        return (len(self.begins) - before) / (self.now - begin)


def test_an_idle_machine_keeps_the_frame_rate(monkeypatch: pytest.MonkeyPatch) -> None:
    machine = Machine(monkeypatch, 4, drawing=1e-3)
    assert machine.run(10.0) == pytest.approx(1.0 / FRAME, rel=0.02)
    assert all(
        session.simulation.time == pytest.approx(machine.now, rel=0.02) for session in machine.sessions
    )
    assert not any(session.pace.slowed for session in machine.sessions)
    report = machine.workload.report
    assert (report.frames, report.sessions, report.places) == (32, 4, 4) and 0 < report.load < 50


@pytest.mark.thorough
def test_frame_rates_fall_evenly_and_time_slows_down(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each session's steps take 4 % of the time: a loop that made up every step would get stuck."""
    rates, times = [], []
    for count in (8, 16, 32):
        machine = Machine(monkeypatch, count, drawing=1.5e-3)
        rates.append(machine.run(4.0))
        assert len(set(machine.counts)) == 1, "sessions got different numbers of frames"
        run = [session.simulation.time for session in machine.sessions]
        assert max(run) - min(run) < 0.2, "sessions got different simulated times"
        times.append(run[0] / machine.now)
        # A round takes at most the drawing and the share of steps, exceeded by one step per session.
        allowed = max(SLOWEST, 1.5e-3 * count + LEAST) + count * STEP + 1e-6
        assert max(b - a for a, b in itertools.pairwise(machine.begins[5:])) < allowed
        slowed = [session.pace.slowed for session in machine.sessions]
        assert slowed == [times[-1] < 0.9] * count
        assert (machine.workload.report.load > 95) == (count >= 16)
    assert all(b < 1.03 * a for a, b in itertools.pairwise(rates)) and rates[1] > 20.5 and rates[-1] > 15.0, (
        rates
    )
    assert times == sorted(times, reverse=True) and times[0] > 0.98 and 0.15 < times[-1] < 0.6


@pytest.mark.thorough
def test_after_an_overload_rates_recover(monkeypatch: pytest.MonkeyPatch) -> None:
    machine = Machine(monkeypatch, 5, drawing=2e-3, step=2.0 * STEP)
    machine.run(3.0)
    machine.drawing = 40e-3
    assert machine.run(10.0) < 6.0
    assert all(session.pace.slowed for session in machine.sessions)
    machine.drawing = 2e-3
    begin, times = machine.now, [session.simulation.time for session in machine.sessions]
    machine.run(5.0)
    for session, time in zip(machine.sessions, times, strict=True):
        assert session.simulation.time - time < 1.03 * (machine.now - begin), "missed steps were made up"
    begin, times = machine.now, [session.simulation.time for session in machine.sessions]
    assert machine.run(5.0) == pytest.approx(1.0 / FRAME, rel=0.02)
    for session, time in zip(machine.sessions, times, strict=True):
        assert session.simulation.time - time == pytest.approx(machine.now - begin, rel=0.03)
        assert not session.pace.slowed


def counted(opened: ByHand, seconds: float, rounds: int = 96) -> Counter[str]:
    """Messages of each kind sent to the only visitor in `rounds` frames, `seconds` apart [s]."""
    (visitor,) = opened.visitors
    before = visitor.received.messages.copy()
    for _ in range(rounds):
        frames = visitor.received.frames
        opened.now += seconds
        opened.host.frame(opened.now, seconds)
        visitor.wait_for(lambda v, frames=frames: v.received.frames > frames)
    return visitor.received.messages - before


@pytest.mark.thorough
@pytest.mark.usefixtures("fast_machine")
def test_with_rare_frames_panels_are_drawn_in_fewer_than_the_picture(
    by_hand: Made,
) -> None:
    opened = by_hand(sessions=2)
    opened.let_in()
    # The clock that the page was built by.
    opened.now = perf_counter()
    counted(opened, FRAME, 32)
    often, rare = counted(opened, FRAME), counted(opened, 3.0 * FRAME)
    assert rare["SetOrientationMessage"] > 0.8 * often["SetOrientationMessage"] > 500
    assert rare["GuiUpdateMessage"] < 1.5 * often["GuiUpdateMessage"], "panels were drawn as often as before"


def test_controls_are_updated_rarely_and_at_once_after_an_action(
    by_hand: Made, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = by_hand(sessions=2)
    opened.let_in()
    looks: list[float] = []
    look = Controls.show
    monkeypatch.setattr(Controls, "show", lambda self, frame: [looks.append(frame.now), look(self, frame)])
    for _ in range(96):
        opened.frame()
    assert len(looks) == pytest.approx(96 * FRAME / CALM, rel=0.4)
    while looks[-1] == opened.now:
        opened.frame()
    (session,) = live_sessions(opened.house).values()
    session.post(SetSetting("dm", 0.2))
    opened.frame()
    assert looks[-1] == opened.now


# --- places ------------------------------------------------------------------------------------------


def test_the_number_of_places_follows_the_step_time() -> None:
    assert places(40e-6) > places(140e-6) > places(1e-3) == 1 == places(10.0), "no place on a slow machine"
    assert 15 <= places(41e-6) <= 30
    assert places(40e-6, 4) == 4 * places(40e-6)
    assert affordable(SLOWEST) == affordable(1.0) == 1 and affordable(SLOWEST / 7.5) == 7


def test_the_speed_of_a_step_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    ticks = iter(range(1000))
    monkeypatch.setattr(workload.time, "thread_time", lambda: 0.02 * next(ticks))
    for loaded, factor in ((True, 1.0), (False, GAIN)):
        monkeypatch.setattr(workload, "all_loaded", lambda loaded=loaded: loaded)
        assert step_seconds() == pytest.approx(0.02 / workload.BATCH / factor)


@pytest.mark.thorough
def test_the_step_estimate_before_compilation_matches_the_one_after() -> None:
    """In a separate process, with Python loops at first; the estimate may be off by a factor of two."""
    code = (
        "from app.hosting.workload import step_seconds; from controllers.compiled import all_loaded, load_now\n"
        "assert not all_loaded(); before = step_seconds(); load_now(); assert all_loaded(); print(before / step_seconds())"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=240, check=True
    )
    assert 0.4 < float(done.stdout) < 3.0


def test_measured_frame_times_correct_the_number_of_places() -> None:
    workload = Workload(20, corrected=True)

    def work(sessions: int, each: float, seconds: float = 30.0) -> int:
        for _ in range(round(32 * seconds)):
            for _ in range(sessions):
                workload.drew(0.0)
            workload.note(sessions * each, FRAME)
        return workload.places

    assert work(int(ENOUGH), 20e-3) == 20, "corrected by too few sessions"
    settled = work(10, 4e-3)
    assert settled == pytest.approx(affordable(4e-3), rel=BAND)
    assert work(10, 4e-3 * (1.0 + BAND / 2.0)) == settled, "the number of places flickers"
    assert work(0, 0.0, 60.0) == settled, "corrected without any session"
    assert work(10, 1e-3) == pytest.approx(affordable(1e-3), rel=BAND)
    shared = Workload(60, loops=3, corrected=True)
    for _ in range(1000):
        for _ in range(10):
            shared.drew(0.0)
        shared.note(10 * 4e-3, FRAME)
    assert shared.places == pytest.approx(3 * affordable(4e-3), rel=BAND)
    assert (shared.report.sessions, shared.report.places) == (10, shared.places // 3), "not of this process"
    fixed = Workload(5)
    for _ in range(1000):
        for _ in range(5):
            fixed.drew(0.0)
        fixed.note(1.0, 1.0)
    assert fixed.places == 5


def test_a_visitor_beyond_the_machines_capacity_is_refused(by_hand: Made) -> None:
    opened = by_hand(sessions=None)
    workload, server = opened.house.context.workload, opened.house.server
    assert server.max_clients == workload.places >= 1
    for _ in range(3):
        opened.let_in()
    for _ in range(200):
        for _ in range(3):
            workload.drew(0.0)
        workload.note(3 * 0.9 * SLOWEST / 3, 1.0)
    opened.frame()
    assert server.max_clients == 3 == len(private_of(opened).visitors) and not server._has_room()


# --- the teacher's view ------------------------------------------------------------------------------


def test_a_teacher_sees_frames_sessions_and_load(house: OpenHouse, arrive: Arrive) -> None:
    opened = house(sessions=6, key="12345678")
    plain, teacher = arrive(opened, "lang=en"), arrive(opened, "lang=en&key=12345678")
    teacher.visitor.wait_for(
        lambda v: "sessions at work: 2 of 6" in shown(v) and "frames/s: " in shown(v) and "load: " in shown(v)
    )
    assert "at work" not in shown(plain.visitor)


def test_an_overload_is_highlighted() -> None:
    calm, busy = ServerLoad(32, 5, 20, 40), ServerLoad(14, 28, 20, 140)
    assert load_pills(calm)[::2] == [("", "frames/s: 32"), ("go", "load: 40 %")]
    assert load_pills(busy)[2] == ("halt", "load: 140 %")
