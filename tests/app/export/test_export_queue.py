"""What a visitor keeps: files, a file brought along, and the past beside the live run."""

from __future__ import annotations

import numpy as np
import pytest

from app.export.export_queue import KINDS, ExportQueue, Kind
from app.export.jobs import file_name
from app.recording import replay_player
from app.recording.replay_player import DRAFT
from app.recording.run_file import saved_bytes, saved_from
from app.session.actions import ChangeSpeed, Pause, Reset, SingleStep, Toggle
from app.session.input_sources import InputSources
from app.session.session import Session
from app.session.student_law import LawStatus
from app.settings import Settings
from scenes.inputs import KEEP
from tests.app.export.runs import piece
from tests.app.inline import Inline
from tests.scenes.helpers import given_settings


class Desk:
    """A session, its shelf, and a background that works when it is told to."""

    def __init__(self, people: InputSources | None = None, **settings: object) -> None:
        self.background = Inline()
        self.session = Session(Settings(run=given_settings(**settings)), sources=people or InputSources())
        self.shelf = ExportQueue(self.session, self.background)

    def run(self, seconds: float) -> None:
        """Let the live run go on."""
        for _ in range(round(seconds / 0.05)):
            self.frame(0.05)

    def frame(self, elapsed: float = 0.03) -> bool:
        """One frame."""
        self.session.advance(elapsed, float("inf"))
        return self.shelf.player.advance(elapsed)

    def work(self) -> list[str]:
        """Compute, and take in what came out."""
        kinds = self.background.work()
        self.frame(0.0)
        return kinds


@pytest.fixture
def desk(monkeypatch: pytest.MonkeyPatch) -> Desk:
    """Two seconds of the hold experiment; no frame is cut short on a busy machine."""
    monkeypatch.setattr("app.recording.replay.BUDGET", float("inf"))
    made = Desk()
    made.run(2.0)
    assert made.session.simulation.steps == 400
    return made


# --- files ---------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in ("html", "python")])
def test_a_file_is_made_in_the_background_and_handed_over_once(desk: Desk, kind: Kind) -> None:
    desk.shelf.ask(kind, 1.0)
    assert desk.shelf.busy and not desk.shelf.take_files()
    desk.run(0.1)  # the live run goes on meanwhile
    assert desk.work() == [kind] and not desk.shelf.busy
    (file,) = desk.shelf.take_files()
    assert file.name.startswith("duet-hold-") and file.name.endswith({"run": ".duet.npz"}.get(kind, f".{kind}"))
    assert len(file.content) > 1000 and not desk.shelf.take_files() and not desk.shelf.take_news()


def test_the_page_that_plays_gets_what_the_page_shows(desk: Desk) -> None:
    desk.session.change("plot", "lambda")
    desk.shelf.ask("html", 1.0)
    (job,) = desk.background.waiting()
    language, recorded, seconds, page = job.arguments
    assert (recorded.steps, seconds, page.details) == (200, 1.0, "lambda") or recorded.seconds >= 1.0
    assert page is desk.session.settings.page and language == "en"


def test_a_saved_run_is_the_run(desk: Desk) -> None:
    table = desk.session.simulation.history.table()
    desk.shelf.ask("run", KEEP)
    desk.work()
    (file,) = desk.shelf.take_files()
    kept = saved_from(file.content, file.name)
    assert kept.recorded.steps == 400 and kept.outcome.rows[-1].tobytes() == table[-1].tobytes()
    assert file.name == "duet-hold-0-2s.duet.npz" == f"{file_name(kept.recorded, KEEP)}.duet.npz"


def test_a_run_that_would_come_out_differently_is_not_saved(desk: Desk) -> None:
    # As after a mistake of ours: somebody has pushed the arm.
    desk.session.simulation.positions[2] += 1e-9
    desk.run(0.1)
    desk.shelf.ask("run", KEEP)
    desk.work()
    (news,) = desk.shelf.take_news()
    assert "comes out differently" in news.text and not desk.shelf.take_files()


def test_lines_of_python_are_of_the_chosen_piece(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    """Live and replayed; inputs that are too many for the text come as a file with them, of that piece as well."""
    desk.shelf.ask("python", 0.5)
    desk.work()
    snippet = desk.shelf.take_snippet()
    assert snippet is not None and "table[-100:]" in snippet and desk.shelf.take_snippet() is None
    desk.session.change("k", 3.0)
    desk.run(0.2)
    monkeypatch.setattr("app.export.python_snippet.MOST_CHARACTERS", 100)
    for _ in range(2):
        desk.shelf.ask("python", 0.5)
        desk.work()
        snippet = desk.shelf.take_snippet()
        (file,) = desk.shelf.take_files()
        assert snippet is not None and f"Path({file.name!r})" in snippet and "from t = 1.7 s to 2.2 s" in snippet
        saved = saved_from(file.content, file.name).recorded
        assert saved.begin == pytest.approx(1.7) and saved.steps == 100
        desk.shelf.player.watch(KEEP)
        desk.work()


def test_before_the_first_step_there_is_nothing(desk: Desk) -> None:
    for empty in (Desk(), desk):
        if empty is desk:
            # The log still has the run before; nobody asked for that.
            desk.session.toggle_pause()
            desk.session.reset()
        for kind in KINDS:
            empty.shelf.ask(kind, 10.0)
        empty.shelf.player.watch(10.0)
        assert not empty.background.waiting() and len(empty.shelf.take_news()) == len(KINDS) + 1
        assert empty.shelf.player.replay is None


def test_a_law_of_ones_own_gives_numbers_but_no_second_run(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Session, "student_law", property(lambda _: LawStatus("my_law.py")))
    for kind in ("run", "html", "python"):
        desk.shelf.ask(kind, 1.0)
    desk.shelf.player.watch(1.0)
    news = desk.shelf.take_news()
    assert len(news) == 4 and all("my_law.py runs in its own process" in entry.text for entry in news)
    assert not desk.background.waiting() and not desk.session.paused
    desk.shelf.ask("csv", 1.0)
    (job,) = desk.background.waiting()
    table = job.arguments[-1]
    assert table.tobytes() == desk.session.simulation.history.table(job.arguments[0].steps).tobytes()


# --- the past ------------------------------------------------------------------------------------------------------------------


def test_watching_stops_the_live_run_and_goes_back_to_it(desk: Desk) -> None:
    simulation, table = desk.session.simulation, desk.session.simulation.history.table()
    before = simulation.steps
    desk.shelf.player.watch(1.0)
    assert desk.session.paused and desk.shelf.player.past is None and desk.shelf.busy == "the replay"
    desk.work()
    replay, past = desk.shelf.player.replay, desk.shelf.player.past
    assert replay is not None and past is not None and replay.playing
    desk.frame(0.1)
    row = past.simulation.history.table(1)[0]
    assert row.tobytes() == table[np.searchsorted(table[:, 0], row[0])].tobytes()
    assert simulation.steps == before and past.simulation is not simulation
    desk.shelf.player.leave()
    assert desk.shelf.player.past is None and not desk.session.paused
    desk.run(0.1)
    assert simulation.steps == before + 20


def test_a_run_that_was_paused_stays_paused(desk: Desk) -> None:
    desk.session.toggle_pause()
    desk.shelf.player.watch(1.0)
    desk.work()
    desk.shelf.player.leave()
    assert desk.session.paused


def test_any_moment_is_a_move_of_the_slider_away(desk: Desk) -> None:
    desk.shelf.player.watch(KEEP)
    desk.work()
    assert desk.shelf.player.replay is not None
    desk.shelf.player.seek(0.7)
    desk.shelf.player.seek(1.3)
    assert desk.frame()
    assert desk.shelf.player.replay.time == pytest.approx(1.3) and not desk.shelf.player.replay.playing
    assert not desk.frame()


def test_keys_are_about_the_replay_while_there_is_one(desk: Desk) -> None:
    assert not desk.shelf.player.take(Pause())
    desk.shelf.player.watch(KEEP)
    desk.work()
    replay = desk.shelf.player.replay
    assert replay is not None and desk.shelf.player.take(Pause()) and not replay.playing
    step = replay.step
    assert desk.shelf.player.take(SingleStep()) and replay.step == step + 1
    assert not desk.shelf.player.take(Toggle("avoidance")) and not desk.shelf.player.take(ChangeSpeed(-1))
    assert desk.shelf.player.take(Pause()) and replay.playing
    assert desk.shelf.player.take(Reset()) and desk.shelf.player.replay is None and desk.session.simulation.steps == 400


def test_the_page_s_speed_is_that_of_the_replay(desk: Desk) -> None:
    desk.shelf.player.watch(KEEP)
    desk.work()
    assert desk.shelf.player.replay is not None
    desk.session.change("speed", 0.5)
    step = desk.shelf.player.replay.step
    desk.frame(0.1)
    assert desk.shelf.player.replay.step == step + 10


@pytest.mark.parametrize("act", ["pause", "change", "scene"])
def test_whoever_goes_on_or_changes_the_experiment_is_back_at_once(desk: Desk, act: str) -> None:
    desk.shelf.player.watch(1.0)
    desk.work()
    {
        "pause": desk.session.toggle_pause,
        "change": lambda: desk.session.change("dm", 0.2),
        "scene": lambda: desk.session.change("scene", "ball"),
    }[act]()
    desk.frame(0.0)
    assert desk.shelf.player.replay is None and not desk.session.paused


def test_colours_may_be_changed_while_looking_back(desk: Desk) -> None:
    desk.shelf.player.watch(1.0)
    desk.work()
    desk.session.change("theme", "dark")
    desk.frame(0.0)
    past = desk.shelf.player.past
    assert past is not None and past.settings.page.theme == "dark"


def test_the_newest_part_of_a_long_run_is_there_first(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(replay_player, "DRAFT", 0.5)
    desk.shelf.player.watch(KEEP)
    (job,) = desk.background.waiting()
    assert job.urgent and job.arguments[0].steps < 400
    desk.work()
    assert desk.shelf.player.replay is not None and desk.shelf.player.replay.steps < 400
    desk.shelf.player.seek(1.75)
    desk.frame(0.0)
    (job,) = desk.background.waiting()
    assert job.arguments[0].steps == 400
    desk.work()
    # It grows at its beginning; the moment stays.
    assert (
        desk.shelf.player.replay.steps == 400
        and desk.shelf.player.replay.time == pytest.approx(1.75)
        and not desk.shelf.player.replay.playing
    )
    assert DRAFT > 0.5


def test_leaving_drops_what_is_being_made(desk: Desk) -> None:
    desk.shelf.player.watch(1.0)
    desk.shelf.player.leave()
    assert not desk.background.waiting() and not desk.shelf.busy and not desk.session.paused
    desk.shelf.ask("csv", 1.0)
    desk.shelf.close()
    assert not desk.background.waiting() and not desk.shelf.busy


# --- a file brought along ------------------------------------------------------------------------------------------------------


def test_a_file_is_compared_and_replayed(desk: Desk) -> None:
    recorded, table = piece("ball", 1.0)
    desk.shelf.load(saved_bytes(recorded), "theirs.duet.npz")
    assert desk.shelf.busy == "the run of the file" and not desk.session.paused
    assert desk.work() == ["load"]
    (news,) = desk.shelf.take_news()
    assert news.title == "Loaded: the same run" and news.text.startswith("theirs.duet.npz: Made again: all 200 steps")
    assert desk.work() == ["film"]
    past = desk.shelf.player.past
    assert past is not None and past.settings.run.scene == "ball" and desk.shelf.player.loaded == "theirs.duet.npz"
    assert past.simulation.history.table(1)[0].tobytes() == table[0].tobytes()
    # What is kept now is kept of the file's run.
    desk.shelf.ask("csv", 9.0)
    desk.work()
    assert desk.shelf.take_files()[0].name == "duet-ball-0-1s.csv"
    desk.shelf.player.watch(1.0)
    assert desk.shelf.player.loaded == "" and desk.session.paused
    desk.shelf.player.leave()
    assert not desk.session.paused


def test_a_bad_file_changes_nothing(desk: Desk) -> None:
    desk.shelf.load(b"PK no file at all", "mine.npz")
    desk.work()
    (news,) = desk.shelf.take_news()
    assert news.title == "This file was not loaded" and news.text.startswith("mine.npz: ")
    assert desk.shelf.player.replay is None and not desk.session.paused
