"""Review of a moment of a paused run, by a lesson or a visitor."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from app.features.lessons.bookmark import Phase
from app.features.lessons.session import lesson_actions as do
from app.features.studies.background_studies import BackgroundStudies, magnified
from app.page.panels.shown_moment import moment_html
from app.session.actions import Pause, Reset, SetSetting
from app.session.frame import Frame, make_frame
from app.session.replay import AHEAD, Replay, make_film
from app.session.replay_player import ReplayPlayer
from app.session.session import Session
from app.settings import PageSettings, Settings
from scenes.history import COLUMN
from scenes.settings import RunSettings
from tests.app.features.lessons.helpers import lessons_in, our_book
from tests.app.inline import Inline

BOOK = our_book()


class Watched:
    """A session with background jobs; tests make each frame."""

    def __init__(self, settings: Settings | None = None) -> None:
        self.pool = Inline()
        self.session = Session(settings or Settings(), background=self.pool)
        self.lessons = lessons_in(self.session, BOOK)
        self.now = 0.0

    @property
    def player(self) -> ReplayPlayer:
        return self.session.player

    def frame(self, elapsed: float = 0.05) -> Frame:
        self.now += elapsed
        self.pool.work("film")
        return make_frame(self.session, self.now, elapsed, 1e9)

    def run(self, seconds: float) -> None:
        end = self.session.simulation.time + seconds
        while self.session.simulation.time < end:
            self.frame()

    def observe(self, lesson: int, step: int) -> list[Frame]:
        """Frames from the first answer and the run to the outcome."""
        self.lessons.enter(lesson, step)
        self.lessons.act(do.Choose(0))
        self.lessons.act(do.Press("run"))
        self.lessons.runner.further.result(60.0)
        frames: list[Frame] = []
        while self.lessons.walk.phase is not Phase.OBSERVE:
            frames.append(self.frame())
        return frames


def test_a_finished_run_is_shown_at_its_moment_with_complete_plots() -> None:
    watched = Watched()
    for live in watched.observe(5, 0):
        assert live.of_live and not live.replayed
    frame = watched.frame()
    table = watched.session.simulation.history.table()
    nearest = int(table[:, COLUMN["d"]].argmin())
    assert frame.replayed and frame.of_live and frame.shown.replay.reviewed
    assert frame.sample.distance == table[nearest, COLUMN["d"]]
    assert_array_equal(frame.sample.positions, watched.session.simulation.history.positions(table)[nearest])
    assert frame.shown.replay.mark is not None and str(frame.shown.replay.mark.name) == "smallest d − dₘ"
    assert frame.traced == (watched.session.simulation, None) and frame.settings == watched.session.settings
    # The lesson's numbers are of that moment.
    assert (
        dict(watched.lessons.live(frame.simulation)).keys()
        and watched.session.simulation.time > frame.simulation.time + 0.5
    )
    said = moment_html(frame, (0.0, 4.0))
    assert "smallest d − dₘ, 3.1 s" in said and f"--duet-moment:{25.0 * frame.simulation.time:.2f}%" in said
    # The run is recorded, not the moment.
    kept = watched.player.recorded(60.0)
    assert kept is not None and kept.steps == len(table)
    # *Run* repeats the run to its end; then it is shown at its moment again.
    watched.lessons.act(do.Press("run"))
    assert not watched.player.reviewing and not watched.frame().replayed
    while not watched.player.reviewing:
        assert watched.frame().simulation.time < 4.1
    assert (
        watched.lessons.walk.phase is Phase.OBSERVE
        and watched.frame().shown.replay.mark == frame.shown.replay.mark
    )


def test_a_contrast_run_is_shown_at_its_moment_with_both_runs() -> None:
    watched = Watched()
    watched.observe(5, 0)
    watched.lessons.act(do.Press("why"))
    assert watched.lessons.walk.showing
    watched.lessons.runner.further.result(60.0)
    while not watched.player.reviewing:
        watched.frame()
    frame, ghost = watched.frame(), watched.session.ghost
    assert (
        frame.ghost is not None and ghost is not None and frame.traced == (watched.session.simulation, ghost)
    )
    table = ghost.history.table()
    row = int(np.abs(table[:, COLUMN["t"]] - frame.ghost.sample().time).argmin())
    assert abs(frame.ghost.time - frame.simulation.time) < 1e-9 and frame.ghost.time < ghost.time
    assert_array_equal(frame.ghost.sample().positions, ghost.history.positions(table)[row])


@pytest.mark.parametrize("ghost", ["off", "frozen"])
def test_a_visitor_can_review_moments_of_a_paused_run(ghost: str) -> None:
    watched = Watched(Settings(page=PageSettings(ghost=ghost)))
    session, player = watched.session, watched.player
    session.handlers.do(Pause())
    player.review(1.0)
    frame = watched.frame()
    assert not frame.replayed and not player.reviewing and moment_html(frame, None) == "", (
        "there is no moment before the first step"
    )
    session.handlers.do(Pause())
    watched.run(3.0)
    player.review(1.0)
    assert not watched.frame().replayed, "a moving run shows no moment"
    session.handlers.do(Pause())
    end = session.simulation.positions.copy()
    player.review(1.0)
    frame = watched.frame()
    assert frame.simulation.time == pytest.approx(1.0) and (frame.ghost is None) == (ghost == "off")
    if frame.ghost is not None and session.ghost is not None:
        row = round(1.0 / session.settings.run.dt) - 1
        assert_array_equal(
            frame.ghost.sample().positions,
            session.ghost.history.positions(session.ghost.history.table())[row],
        )
    table = session.simulation.history.table()
    assert frame.shown.replay.mark is not None
    assert frame.shown.replay.mark.time == pytest.approx(
        table[table[:, COLUMN["d"]].argmin(), COLUMN["t"]] + session.settings.run.dt
    )
    player.review(2.0)
    assert watched.frame().simulation.time == pytest.approx(2.0)
    player.review(1e6)
    assert watched.frame().simulation.time == pytest.approx(session.simulation.time)
    # Space continues from the end of the run.
    player.review(0.5)
    watched.frame()
    session.handlers.do(Pause())
    assert_array_equal(session.simulation.positions, end)
    assert not watched.frame().replayed and not session.paused and session.simulation.time > 3.0


def test_a_reset_or_a_changed_setting_ends_the_review() -> None:
    for act in (Reset(), SetSetting("dm", 0.2)):
        watched = Watched()
        watched.run(1.0)
        watched.session.handlers.do(Pause())
        watched.player.review(0.5)
        assert watched.frame().replayed
        watched.session.handlers.do(act)
        assert not watched.frame().replayed and watched.session.paused


def test_a_moment_outside_the_plots_has_a_name_but_no_line() -> None:
    watched = Watched()
    watched.run(1.0)
    watched.session.handlers.do(Pause())
    watched.player.review(0.5)
    frame = watched.frame()
    for span in ((0.7, 1.0), (0.0, 0.3)):
        said = moment_html(frame, span)
        assert (
            "--duet-moment-words" in said
            and "--duet-moment:" not in said
            and "--duet-moment-line" not in said
        )
    for span, place in (((0.0, 1.0), "50.00%"), ((0.0, 0.49), "100.00%")):
        said = moment_html(frame, span)
        assert f"--duet-moment:{place}" in said and "--duet-moment-line" in said


def test_the_axis_of_a_long_replay_moves_only_now_and_then() -> None:
    watched = Watched(Settings(RunSettings(scene="imitation", dt=0.01)))
    watched.run(34.0)
    recorded = watched.session.inputs.window(600.0)
    assert recorded is not None
    replay = Replay(make_film(recorded))
    ends: list[float] = []
    for time in np.arange(0.5, 34.0, 0.5):
        replay.seek(float(time))
        traced = replay.traced
        assert traced.history.count and replay.traced is traced
        ends.append(float(traced.history.column("t")[-1]))
        assert replay.time - 0.05 <= ends[-1] + 0.04 and replay.time > ends[-1] - AHEAD - 0.1
    assert len(set(ends)) == 4
    # A short replay is shown completely.
    short = watched.session.inputs.window(15.0)
    assert short is not None
    replay = Replay(make_film(short))
    replay.seek(replay.begin)
    assert float(replay.traced.history.column("t")[-1]) == pytest.approx(replay.end, abs=0.05)


def test_single_steps_around_the_moment_are_magnified() -> None:
    watched = Watched()
    watched.observe(2, 1)
    frame = watched.frame()
    table = watched.session.simulation.history.table()
    # The first jump; it is not the largest one.
    lam = table[:, COLUMN["lambda"]]
    first = float(table[np.flatnonzero((lam[1:] > 0.5) & (lam[:-1] < 0.5))[0] + 1, COLUMN["t"]])
    seen = magnified(frame)
    assert seen is not None and seen.time == first
    steps = np.abs(np.diff(watched.session.simulation.history.velocities(table), axis=0)).max(axis=1)
    assert abs(float(table[steps.argmax() + 1, COLUMN["t"]]) - first) > 0.1
    assert frame.shown.replay.mark is not None and frame.shown.replay.mark.time == pytest.approx(
        first + watched.session.settings.run.dt
    )
    said = moment_html(frame, (0.0, 5.0))
    assert f"--duet-mark:{20.0 * frame.shown.replay.mark.time:.2f}%" in said and "@container" in said
    assert "--duet-mark:" not in moment_html(frame, (4.0, 5.0)), "the moment is outside the axes"


def test_the_first_lesson_starts_the_process_for_replays_once() -> None:
    watched = Watched()
    jobs = watched.session.parts.of(BackgroundStudies).questions._jobs
    watched.lessons.enter(0, 0)
    assert jobs.kinds == ("warm",), "the process starts before Run is pressed"
    watched.pool.work("warm")
    watched.frame()
    watched.lessons.enter(1, 0)
    assert jobs.kinds == (), "the process starts only once"
