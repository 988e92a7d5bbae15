"""`lwr-duet league`: its files, the same bytes everywhere, continuation, and the cost of a broken file."""

import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from app.__main__ import run_command as main
from app.features.league import LEAGUE, command, entrants, league_page
from app.features.league import league_runs as league
from app.features.league.entrants import Entrant, played
from app.features.league.league_files import PART, Played
from app.features.league.league_page import COLUMNS, league_rows
from app.features.league.league_runs import (
    LEVELS,
    ROBOTS,
    SCENES,
    Event,
    LeagueRun,
    Outcome,
    Schedule,
    events,
)
from app.features.marks.fence import FenceLimits
from app.runtime.terminal import INTERRUPTED
from controllers.errors import LazyText
from scenes.experiments import HOLD
from scenes.laws import DEFAULT_LAW, LAWS, NO_AVOIDANCE
from tests.app.features.custom_law.helpers import PAPER, write
from tests.app.features.said import lines_of
from tests.app.features.studies.test_searches import interrupted
from tests.app.features.sweep.test_dask_sweep import scheduler, worker
from tests.app.html_reader import HtmlReader
from tests.approved import Approve

pytestmark = pytest.mark.slow

ISOLATED = "how well a file is fenced"
TINY = Schedule(2.0, (0.5,), (2,))
FILES = ["league.csv", "league.html", "league.json", "league.md", PART, "times.csv"]


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shorten the runs; use one scene and two laws, which represent the others."""
    monkeypatch.setattr(league, "QUICK", TINY)
    monkeypatch.setattr(entrants, "LAWS", {name: LAWS[name] for name in (DEFAULT_LAW, NO_AVOIDANCE)})
    for module in (league, league_page):
        monkeypatch.setattr(module, "SCENES", (HOLD,))
    monkeypatch.setattr(command, "ISOLATION", dict.fromkeys(("full", "network", "none"), ISOLATED))


@pytest.fixture
def one_robot(small: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Shorten the runs and use only the ideal robot."""
    for module in (league, league_page):
        monkeypatch.setattr(module, "ROBOTS", {"ideal": ROBOTS["ideal"]})


def play(out: Path, *more: str) -> int:
    return main(["league", "--quick", "--out", str(out), *more])


@pytest.mark.thorough
@pytest.mark.usefixtures("small")
def test_a_restarted_league_continues_and_writes_the_same_everywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], approve: Approve
) -> None:
    """On one core, on two cores and on a cluster."""
    here, two, cluster = tmp_path / "here", tmp_path / "two", tmp_path / "cluster"
    whole, word = command.computing, ("--seed-word", "pear")

    @contextmanager
    def part(*arguments: Any) -> Iterator[Any]:
        with whole(*arguments) as compute:
            yield interrupted(compute, 3)

    with monkeypatch.context() as patch:
        patch.setattr(command, "computing", part)
        assert play(here, *word, "--workers", "1") == INTERRUPTED
    said = capsys.readouterr()
    approve("interrupted.txt", said.err.splitlines()[-1].replace(str(here / PART), "PART") + "\n")
    # With built-in laws only, no sentence is needed.
    assert "how well" not in said.err
    assert [path.name for path in here.iterdir()] == [PART]
    with (here / PART).open("a", encoding="utf-8") as file:
        # A power failure during the writing of a line.
        file.write('{"name":"smooth_pri')
    assert play(here, *word, "--workers", "1") == 0
    assert play(two, *word, "--workers", "2") == 0
    with scheduler(tmp_path) as (_, address), worker(tmp_path, address):
        assert play(cluster, *word, "--scheduler", address) == 0
    assert sorted(path.name for path in here.iterdir()) == FILES
    for there in (two, cluster):
        for name in ("league.csv", "league.json"):
            assert (here / name).read_bytes() == (there / name).read_bytes()
    found = json.loads((here / "league.json").read_text(encoding="utf-8"))
    assert found["edition"] == league.EDITION and found["versions"]["numpy"] and len(found["outcomes"]) == 8
    assert found["settings"]["hold, delayed"]["dead"] == 0.02 and found["schedule"]["speeds"] == [0.5]
    assert not any(b"pear" in path.read_bytes() for path in here.iterdir())
    assert "hidden half" in (here / "league.md").read_text(encoding="utf-8")
    capsys.readouterr()
    assert play(here) == 2
    approve("refusal of another league.txt", capsys.readouterr().err.replace(str(tmp_path), "FOLDER"))


@pytest.mark.thorough
@pytest.mark.usefixtures("one_robot")
def test_a_broken_file_costs_its_row_and_a_new_file_only_its_own_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, out = tmp_path / "laws", tmp_path / "out"
    folder.mkdir()
    write(folder / "<b>paper.py", PAPER)
    write(tmp_path / "broken.py", "def law(situation):\n    return situation.nominal * float('nan')\n")
    assert play(out, str(tmp_path / "broken.py"), "--workers", "2") == 0
    assert capsys.readouterr().err.count(ISOLATED) == 1
    seen: list[tuple[str, Event]] = []

    def watched(entrant: Entrant, schedule: Schedule, event: Event, *more: Any) -> Outcome:
        seen.append((entrant.name, event))
        return played(entrant, schedule, event, *more)

    monkeypatch.setattr(entrants, "played", watched)
    assert play(out, str(tmp_path / "broken.py"), str(folder), "--workers", "1") == 0
    assert seen == [("<b>paper.py", event) for event in events()]
    lines = (out / "league.md").read_text(encoding="utf-8").splitlines()
    rows, broken = (
        [line for line in lines if line.startswith(f"| {name} ")] for name in ("<b>paper.py", "broken.py")
    )
    assert len(rows) == len(broken) == len(LEVELS)
    assert all("broken.py, line 1: law" in line for line in broken)
    # At equal safety; in such short runs the arms do not come close in every scene.
    assert all("offset of d = " in line or "no value of its knob" in line for line in rows[1:])
    page = (out / "league.html").read_text(encoding="utf-8")
    read = HtmlReader(page)
    assert "<b>paper.py" in read.text and "<b>" not in page and "<script" not in page
    assert (
        set(read.links) == {"#projector", "#"} and page.count("<svg") == 2 and 'content="default-src' in page
    )


@pytest.mark.thorough
@pytest.mark.usefixtures("one_robot")
def test_a_file_that_runs_out_of_time_gets_another_try_with_more_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tries: list[float] = []

    def endless(module: str, arguments: Any, text: bytes, take: Any, limits: FenceLimits) -> str:
        tries.append(limits.seconds)
        return LazyText("it did not end within {seconds:g} s", seconds=limits.seconds)

    monkeypatch.setattr(entrants, "fenced", endless)
    write(tmp_path / "endless.py", PAPER)
    for seconds in ("2", "2", "3"):
        assert (
            play(tmp_path / "out", str(tmp_path / "endless.py"), "--workers", "1", "--seconds", seconds) == 0
        )
        assert f"did not end within {tries[-1]:g} s" in (tmp_path / "out" / "league.md").read_text(
            encoding="utf-8"
        )
    assert tries == [2.0] * len(list(events())) + [3.0] * len(list(events()))
    assert "given_up" not in (tmp_path / "out" / "league.json").read_text(encoding="utf-8")


def test_every_file_plays_once_under_a_unique_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "anna"
    folder.mkdir()
    paths = [Path("anna", "my_law.py"), Path("my_law.py"), Path(NO_AVOIDANCE)]
    for path in paths:
        write(tmp_path / path, f"# {path}\n{PAPER}")
    found = entrants.entrants([*paths, tmp_path / "my_law.py", paths[0]])
    names = [one.name for one in found if one.text is not None]
    assert names == ["my_law.py", str(tmp_path / "my_law.py"), str(tmp_path / NO_AVOIDANCE)]


REFUSED = (
    "--seconds 0",
    "--workers -1",
    "--workers 2 --scheduler tcp://127.0.0.1:1",
    "missing.py",
    ".",
    "--out new --scheduler tcp://127.0.0.1:1",
    "--out damaged",
)


def test_invalid_options_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], approve: Approve
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").touch()
    (tmp_path / "damaged").mkdir()
    (tmp_path / "damaged" / PART).write_text("{}\nnonsense\n", encoding="utf-8")
    said = dict[str, str]()
    for options in REFUSED:
        assert main(["league", "--quick", *options.split()]) == 2 and not Path("new").exists()
        said[options] = capsys.readouterr().err.rstrip().replace(str(tmp_path), "FOLDER")
    # Dask's own text differs by version.
    approve("refusals.txt", re.sub(r"answers there \(.*?\)", "answers there (…)", lines_of(said)))
    # The text for a folder that is a file differs by system.
    assert main(["league", "--quick", "--out", "file/out"]) == 2
    assert "cannot be written" in capsys.readouterr().err


def outcome(*figures: tuple[float, float, float]) -> Outcome:
    """An outcome with runs of these losses, smallest distances and errors."""
    runs = tuple(
        LeagueRun("public", i, 0.5, lost, d_min, e2, 0.1, 0.4)
        for i, (lost, d_min, e2) in enumerate(figures, 1)
    )
    return Outcome(None, None, runs, 40.0)


def test_a_row_has_its_worst_run_and_its_error_relative_to_the_paper() -> None:
    mine = [Entrant(DEFAULT_LAW), Entrant(NO_AVOIDANCE)]
    paper, other = outcome((0.0, 0.16, 0.1), (0.0, 0.15, 0.3)), outcome((0.01, 0.14, 0.1), (0.05, 0.10, 0.1))
    known = [
        Played(name, "", Event(scene, "ideal", level), of)
        for level in LEVELS
        for name, of in ((DEFAULT_LAW, paper), (NO_AVOIDANCE, other))
        for scene in SCENES
    ]
    first, second = league_rows(mine, known, TINY, "default", "ideal")
    assert (first.entrant, first.lost, first.d_min, first.e2) == (mine[0], 0.0, 0.15, pytest.approx(1.0))
    assert (second.lost, second.d_min, second.e2, second.dq_step) == (0.05, 0.10, pytest.approx(0.5), 0.1)
    assert second.at_bounds == pytest.approx(0.5), "0.4 s of 2 s · 0.2 / 0.5"
    # At equal safety the error decides; one missing scene gives no error.
    assert [row.entrant for row in league_rows(mine, known, TINY, "equal", "ideal")] == mine[::-1]
    away = (NO_AVOIDANCE, "ball")
    gap = [
        replace(one.outcome, runs=(), problem="why") if (one.name, one.event.scene) == away else one.outcome
        for one in known
    ]
    partial = [Played(one.name, "", one.event, of) for one, of in zip(known, gap, strict=True)]
    last = league_rows(mine, partial, TINY, "equal", "ideal")[-1]
    assert (last.entrant, last.e2, last.notes) == (mine[1], None, ("a ball in the way: why",)) and len(
        last.cells()
    ) == len(COLUMNS)


@pytest.mark.thorough
def test_the_document_has_the_tables_of_the_built_in_laws() -> None:
    text = LEAGUE.documents["league"].file.read_text(encoding="utf-8")
    tables = re.findall(r"^### (.+)\n\n((?:\|.*\n)+)", text, re.MULTILINE)
    assert [title for title, _ in tables] == [
        f"{title}, {robot} robots" for title in LEVELS.values() for robot in ROBOTS
    ]
    found = {
        title: {row.split(" | ")[0].removeprefix("| "): row for row in table.splitlines()[2:]}
        for title, table in tables
    }
    assert all(set(rows) == {law.label for law in LAWS.values() if law.in_league} for rows in found.values())
    assert f"edition {league.EDITION}" in text.lower()
    # One row recomputed: everything except the wall time.
    paper = Entrant(DEFAULT_LAW)
    ideal = [event for event in events() if (event.level, event.robot) == ("default", "ideal")]
    known = [
        Played(paper.name, "", event, league.law_held(paper.name, league.FULL, event)) for event in ideal
    ]
    (row,) = league_rows([paper], known, league.FULL, "default", "ideal")
    written = found[f"{LEVELS['default']}, ideal robots"][paper.label].strip("| ").split(" | ")
    assert written[:6] == list(row.cells()[:6])
