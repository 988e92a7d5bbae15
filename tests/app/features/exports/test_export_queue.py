"""A visitor's exports, loaded file and replay beside the live run; unwanted jobs end at once."""

from collections.abc import Callable
from functools import cache
from typing import Any, get_args

import numpy as np
import pytest

from app.features.exports.csv_table import csv_bytes
from app.features.exports.export_queue import ExportQueue, FileKind, file_name
from app.features.exports.player import player_html
from app.features.exports.plot_pictures import picture_bytes
from app.features.exports.python_snippet import is_fresh
from app.features.exports.scene_film import film_scene
from app.features.lab_report.lab_report import Done, lab_bytes
from app.features.lessons.loading import load_lessons
from app.features.lessons.progress import StepProgress
from app.features.studies.background_studies import trade_off_row
from app.page.panels.readout import replay_html
from app.recording.run_file import SavedRun, saved_bytes, saved_from, verify
from app.session import replay_player
from app.session.actions import ChangeSpeed, Pause, Reset, SingleStep
from app.session.replay import Replay, make_film
from app.session.replay_player import DRAFT
from app.session.session import Session
from app.settings import PageSettings, Settings
from scenes.inputs import KEEP, Recorded
from scenes.settings import RunSettings
from scenes.wanted import Stopped, until
from tests.app.inline import Inline
from tests.app.recording.runs import piece
from tests.approved import Approve


class Desk:
    """A session, its exports, and a background that works only on request."""

    def __init__(self) -> None:
        self.background = Inline()
        self.session = Session(Settings(), background=self.background)
        self.queue = ExportQueue(self.session, self.session.player)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.05)):
            self.frame(0.05)

    def frame(self, elapsed: float = 0.03) -> None:
        self.session.advance(elapsed, float("inf"))
        self.queue.player.advance(elapsed)

    def take_news(self) -> list[tuple[str, str]]:
        news = list(self.session.notices)
        self.session.notices.clear()
        return news

    def watch(self, seconds: float) -> Replay:
        self.queue.player.watch(seconds)
        self.work()
        assert self.queue.player.replay is not None
        return self.queue.player.replay

    def work(self) -> list[str]:
        kinds = self.background.work()
        self.frame(0.0)
        return kinds


@pytest.fixture
def desk(monkeypatch: pytest.MonkeyPatch) -> Desk:
    """Two seconds of the hold experiment; a busy machine shortens no frame."""
    monkeypatch.setattr("app.session.replay.BUDGET", float("inf"))
    made = Desk()
    made.run(2.0)
    assert made.session.simulation.steps == 400
    return made


@pytest.mark.parametrize("kind", [kind for kind in get_args(FileKind) if kind not in ("html", "python")])
def test_a_file_is_made_in_the_background_and_handed_over_once(desk: Desk, kind: FileKind) -> None:
    desk.queue.ask(kind, 1.0)
    assert desk.queue.busy and not desk.queue.take_files()
    desk.run(0.1)  # The live run continues meanwhile.
    assert desk.work() == [kind] and not desk.queue.busy
    (file,) = desk.queue.take_files()
    assert file.name.startswith("duet-hold-") and file.name.endswith(
        {"run": ".duet.npz"}.get(kind, f".{kind}")
    )
    assert len(file.content) > 1000 and not desk.queue.take_files() and not desk.take_news()


def test_the_player_page_matches_the_page(desk: Desk) -> None:
    desk.session.change("plot", "lambda")
    desk.queue.ask("html", 1.0)
    (job,) = desk.background.waiting()
    language, recorded, seconds, page = job.arguments
    assert recorded.seconds >= 1.0 - 1e-9 and (seconds, page.details) == (1.0, "lambda")
    assert page is desk.session.settings.page and language == "en"


def test_a_saved_run_equals_the_run_and_an_irreproducible_one_is_not_saved(desk: Desk) -> None:
    table = desk.session.simulation.history.table()
    desk.queue.ask("run", KEEP)
    desk.work()
    (file,) = desk.queue.take_files()
    kept = saved_from(file.content, file.name)
    assert kept.recorded.steps == 400 and kept.outcome.rows[-1].tobytes() == table[-1].tobytes()
    assert file.name == "duet-hold-0-2s.duet.npz" == f"{file_name(kept.recorded, KEEP)}.duet.npz"
    # Simulates a bug: the arm was moved outside the step.
    desk.session.simulation.positions[2] += 1e-9
    desk.run(0.1)
    desk.queue.ask("run", KEEP)
    desk.work()
    ((_, text),) = desk.take_news()
    assert "gives another result" in text and not desk.queue.take_files()


def test_python_lines_match_the_chosen_piece(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    desk.queue.ask("python", 0.5)
    desk.work()
    snippet = desk.queue.take_snippet()
    assert snippet is not None and "table[-100:]" in snippet and desk.queue.take_snippet() is None
    desk.session.change("k", 3.0)
    desk.run(0.2)
    monkeypatch.setattr("app.features.exports.python_snippet.MOST_CHARACTERS", 100)
    for _ in range(2):
        desk.queue.ask("python", 0.5)
        desk.work()
        snippet = desk.queue.take_snippet()
        (file,) = desk.queue.take_files()
        assert (
            snippet is not None and f"Path({file.name!r})" in snippet and "from t = 1.7 s to 2.2 s" in snippet
        )
        saved = saved_from(file.content, file.name).recorded
        assert saved.begin == pytest.approx(1.7) and saved.steps == 100
        desk.watch(KEEP)


def test_before_the_first_step_nothing_can_be_exported(desk: Desk) -> None:
    for empty in (Desk(), desk):
        if empty is desk:
            # The log still has the previous run, which was not requested.
            desk.session.control.toggle_pause()
            desk.session.reset()
        for kind in get_args(FileKind):
            empty.queue.ask(kind, 10.0)
        empty.queue.player.watch(10.0)
        assert not empty.background.waiting() and len(empty.take_news()) == len(get_args(FileKind)) + 1
        assert empty.queue.player.replay is None


@pytest.mark.parametrize("paused", [False, True])
def test_watching_pauses_the_live_run_and_leaving_continues_it(desk: Desk, paused: bool) -> None:
    simulation, table = desk.session.simulation, desk.session.simulation.history.table()
    before = simulation.steps
    if paused:
        desk.session.control.toggle_pause()
    desk.queue.player.watch(1.0)
    assert desk.session.paused and desk.queue.player.past is None and desk.queue.busy == "the replay"
    desk.work()
    replay, past = desk.queue.player.replay, desk.queue.player.past
    assert replay is not None and past is not None and replay.playing
    desk.frame(0.1)
    row = past.simulation.history.table(1)[0]
    assert row.tobytes() == table[np.searchsorted(table[:, 0], row[0])].tobytes()
    assert simulation.steps == before and past.simulation is not simulation
    desk.queue.player.leave()
    assert desk.queue.player.past is None and desk.session.paused == paused
    desk.run(0.1)
    assert simulation.steps == before + (0 if paused else 20)


def test_slider_keys_and_speed_control_the_replay_while_there_is_one(desk: Desk) -> None:
    do, player = desk.session.handlers.do, desk.queue.player
    for paused in (True, False):
        do(Pause())
        assert desk.session.paused == paused
    replay = desk.watch(KEEP)
    do(ChangeSpeed(-1))
    assert desk.session.settings.page.speed == 0.5
    step = replay.step
    desk.frame(0.1)
    assert replay.step == step + 10
    player.seek(0.7)
    player.seek(1.3)
    desk.frame()
    sought = replay.step
    desk.frame()
    assert replay.step == sought
    assert replay.time == pytest.approx(1.3) and not replay.playing
    step = replay.step
    do(SingleStep())
    assert replay.step == step + 1
    for playing in (True, False):
        do(Pause())
        assert replay.playing == playing and desk.session.paused
    assert player.replay is replay
    do(Reset())
    assert player.replay is None and desk.session.simulation.steps == 400


@pytest.mark.parametrize("change", [(), ("dm", 0.2), ("scene", "ball"), ("theme", "dark")], ids=str)
def test_continuing_or_another_experiment_ends_the_replay_but_not_colours(
    desk: Desk, change: tuple[str, Any]
) -> None:
    desk.watch(1.0)
    if change:
        desk.session.change(*change)
    else:
        desk.session.control.toggle_pause()
    desk.frame(0.0)
    past = desk.queue.player.past
    if "theme" in change:
        assert past is not None and past.settings.page.theme == "dark"
    else:
        assert past is None and desk.queue.player.replay is None and not desk.session.paused


def test_the_newest_part_of_a_long_run_is_ready_first(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(replay_player, "DRAFT", 0.5)
    desk.queue.player.watch(KEEP)
    (job,) = desk.background.waiting()
    assert job.urgent and job.arguments[0].steps < 400
    desk.work()
    assert desk.queue.player.replay is not None and desk.queue.player.replay.steps < 400
    desk.queue.player.seek(1.75)
    desk.frame(0.0)
    (job,) = desk.background.waiting()
    assert job.arguments[0].steps == 400
    desk.work()
    replay = desk.queue.player.replay
    assert replay.steps == 400 and replay.time == pytest.approx(1.75) and not replay.playing
    assert DRAFT > 0.5


def test_leaving_drops_pending_jobs(desk: Desk) -> None:
    desk.queue.player.watch(1.0)
    desk.queue.player.leave()
    assert not desk.background.waiting() and not desk.queue.busy and not desk.session.paused
    desk.queue.ask("csv", 1.0)
    desk.queue.close()
    assert not desk.background.waiting() and not desk.queue.busy


def test_a_loading_run_blocks_the_live_run(desk: Desk) -> None:
    player, recorded = desk.queue.player, piece("ball", 1.0)[0]
    player.watch_file(recorded, "a push from a link")
    assert "is being loaded" in replay_html(desk.session)
    steps, do = desk.session.simulation.steps, desk.session.handlers.do
    for action in (Pause(), SingleStep()):
        do(action)
        desk.session.advance(0.05)
        assert player.coming and desk.session.paused and desk.session.simulation.steps == steps
    desk.work()
    assert (
        player.replay is not None
        and player.past is not None
        and "is being loaded" not in replay_html(player.past)
    )
    # Back to live, as from a replay.
    player.watch_file(recorded, "theirs.duet.npz")
    do(Reset())
    assert not desk.background.waiting() and not desk.session.paused and not player.coming
    assert desk.session.simulation.steps == steps


def test_a_bad_file_changes_nothing(desk: Desk) -> None:
    desk.queue.load(b"PK no file at all", "mine.npz")
    desk.work()
    ((title, text),) = desk.take_news()
    assert title == "This file was not loaded" and text.startswith("mine.npz: ")
    assert desk.queue.player.replay is None and not desk.session.paused


def test_a_file_is_compared_and_replayed(desk: Desk, approve: Approve) -> None:
    recorded, table = piece("ball", 1.0)
    desk.queue.load(saved_bytes(recorded), "theirs.duet.npz")
    assert desk.queue.busy == "the run of the file" and not desk.session.paused
    assert desk.work() == ["load"]
    ((title, text),) = desk.take_news()
    assert title == "Loaded: the same run"
    approve("loaded run.txt", f"{text}\n")
    assert desk.work() == ["film"]
    past = desk.queue.player.past
    assert (
        past is not None
        and past.settings.run.scene == "ball"
        and desk.queue.player.loaded == "theirs.duet.npz"
    )
    assert past.simulation.history.table(1)[0].tobytes() == table[0].tobytes()
    # Exports now contain the file's run.
    desk.queue.ask("csv", 9.0)
    desk.work()
    assert desk.queue.take_files()[0].name == "duet-ball-0-1s.csv"
    desk.queue.player.watch(1.0)
    assert desk.queue.player.loaded == "" and desk.session.paused
    desk.queue.player.leave()
    assert not desk.session.paused


@cache
def saved() -> SavedRun:
    return saved_from(saved_bytes(piece("hold", 1.0)[0]), "a.npz")


JOBS: dict[str, Callable[[Recorded], object]] = {
    "table": lambda run: csv_bytes(run, 1.0),
    "picture": lambda run: picture_bytes(run, 1.0, "none", "png"),
    "player": lambda run: player_html(run, 1.0, PageSettings()),
    "scene": lambda run: film_scene(run, 1.0, PageSettings()),
    "film": make_film,
    "run file": saved_bytes,
    "verification": lambda _: verify(saved()),
    "snippet": is_fresh,
    "report": lambda run: lab_bytes((Done(load_lessons().lessons[0], 0, StepProgress(), run),), "en"),
    "map": lambda run: trade_off_row(RunSettings(dt=0.02), 6.0),
}


@pytest.mark.parametrize("job", JOBS)
def test_a_job_stops(job: str) -> None:
    recorded, _ = piece("hold", 1.0)[0], saved()
    with pytest.raises(Stopped), until(lambda: True):
        JOBS[job](recorded)
