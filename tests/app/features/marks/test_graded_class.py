"""A class of misbehaving files, graded once: each file affects only its own row."""

import csv
import io
import json
import os
import re
from collections.abc import Iterator
from contextlib import redirect_stderr
from dataclasses import dataclass
from pathlib import Path

import pytest

from app.__main__ import run_command as main
from app.features.custom_law.trials import GATES, TRIALS, TRY
from app.features.lab_report.lab_report import Done, lab_bytes
from app.features.lessons.loading import load_lessons
from app.features.lessons.progress import StepProgress
from app.features.marks.graded_file import REPORT
from tests.app.features.custom_law.helpers import PAPER, write
from tests.app.features.marks.helpers import FORKS, LAW, TOO_MANY, nothing_left, posix
from tests.approved import Approve, shown_text

pytestmark = [pytest.mark.thorough, posix]

NASTY = {
    "closes.py": ("import os\nos.closerange(0, 256)\n" + LAW, ""),
    "forks.py": (FORKS, f"{TOO_MANY}|endless loop"),
    "groups.py": (
        "import os\nos.killpg(os.getpgid(os.getppid()) or 1, 9)\nraise RuntimeError('still here')\n",
        "",
    ),
    "kills.py": (
        "import os\nos.kill(os.getppid(), 9)\nos.kill(os.getppid(), 19)\nraise RuntimeError('still here')\n",
        "",
    ),
    "large.py": ("open('a', 'wb').write(bytes(2**25))\n", "File too large"),
    "memory.py": ("a = bytearray(2**34)\n", "wants more memory than the 512 MiB"),
    "prints.py": (
        "import os\nfor _ in range(1000):\n    os.write(1, b'x' * 2**20)\nraise RuntimeError('printed')\n",
        "printed",
    ),
    "doe_7_8_quits.py": ("import os\nos._exit(0)\n", "exit code 0"),
}
"""Names of files → their text, and their reason as a regular expression."""

FORMULA, STILL = "=1+1.py", "Ann Lee_12_assignsubmission_file_/my_law.py"
"""File names: a formula if a table read it; a law that does not move the arm."""


@dataclass(frozen=True)
class Grading:
    """`rows`: by name. `files`: for Moodle, Canvas and Gradescope. `progress`: standard error."""

    header: list[str]
    rows: dict[str, dict[str, str]]
    files: dict[str, str]
    pages: Path
    progress: str


def hand_in(folder: Path) -> None:
    (folder / "deep" / "__pycache__").mkdir(parents=True)
    (folder / "folder.py").mkdir()
    write(folder / "deep" / "good.py", PAPER)
    write(folder / FORMULA, "1/0")
    for name, (text, _) in NASTY.items():
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "bytes.py").write_bytes(b"\xff\xfe\x00def")
    for name in ("huge.py", "huge.html"):
        with (folder / name).open("wb") as file:
            file.truncate(2**30)
    (folder / "empty.html").write_text("<p>nothing</p>", encoding="utf-8")
    (folder / "loop.py").symlink_to("loop.py")
    (folder / "around").symlink_to("..")
    os.mkfifo(folder / "pipe.py")
    (folder / "deep" / "__pycache__" / "no.py").write_text(LAW, encoding="utf-8")
    lesson = next(lesson for lesson in load_lessons().lessons if lesson.id == "hold")
    steps = [Done(lesson, 0, StepProgress(choice=1)), Done(lesson, 2, StepProgress(attempts=2, passed=True))]
    (folder / "report.html").write_bytes(lab_bytes(steps, "de"))
    (folder / STILL).parent.mkdir()
    write(folder / STILL, "def law(s):\n    # It stands still.\n    return 0.0 * s.nominal")


@pytest.fixture(scope="module")
def grading(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Grading]:
    place = tmp_path_factory.mktemp("class")
    hand_in(folder := place / "in")
    table, pages = place / "marks.csv", place / "pages"
    files = {name: place / name for name in ("moodle", "canvas", "gradescope")}
    command = ["grade", str(folder), "--csv", str(table), "--jobs", "2", "--seconds", "150"]
    command += [word for name, path in files.items() for word in (f"--{name}", str(path))]
    command += ["--feedback", str(pages), "--points", "3", "1", "3", "2", "1", "1"]
    with nothing_left(), redirect_stderr(io.StringIO()) as progress:
        assert main(command) == 0
    with table.open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    by_name = {row[0]: dict(zip(header, row, strict=True)) for row in rows}
    assert len(by_name) == len(rows)
    written = {name: path.read_text(encoding="utf-8") for name, path in files.items()}
    yield Grading(header, by_name, written, pages, progress.getvalue())


def test_every_file_has_one_row(grading: Grading) -> None:
    last = ["points", "reason", "student", "id", "maximum", "feedback"]
    assert grading.header == ["name", "kind", *TRIALS, *REPORT, *last]
    others = "bytes.py deep/good.py empty.html huge.html huge.py loop.py pipe.py report.html"
    names = sorted([FORMULA, *others.split(), STILL, *NASTY])
    assert [name.removeprefix("'") for name in grading.rows] == names
    assert f"'{FORMULA}" in grading.rows


def test_the_papers_law_gets_all_points_and_a_still_law_none(grading: Grading) -> None:
    good, still = grading.rows["deep/good.py"], grading.rows[STILL]
    assert [good[name] for name in TRIALS] == ["pass"] * 6 and good["points"] == "11"
    assert [still[name] for name in TRIALS] == ["fail"] * 3 + ["pass"] * 3
    assert [still[key] for key in ("points", "maximum", "student", "id")] == ["0", "11", "Ann Lee", "12"]


def test_a_report_gets_a_point_for_each_right_answer_and_passed_step(grading: Grading) -> None:
    row = grading.rows["report.html"]
    assert [row[key] for key in ("kind", *REPORT, "points")] == ["report", "2", "1", "0", "1", "1", "2", "1"]


def test_every_other_file_has_its_reason(grading: Grading, approve: Approve) -> None:
    reasons = {name: row["reason"] for name, row in grading.rows.items()}
    said = {name: text for name, (_, text) in NASTY.items()} | {f"'{FORMULA}": "division by zero"}
    assert {name: reasons[name] for name, text in said.items() if not re.search(text, reasons[name])} == {}
    assert [name for name, reason in reasons.items() if not reason] == ["deep/good.py"]
    read = ("bytes.py", "empty.html", "huge.html", "huge.py", "loop.py", "pipe.py")
    approve("reasons en.txt", "".join(f"{name}: {reasons[name]}\n" for name in (*read, "memory.py")))


def test_feedback_names_the_line_and_what_to_try(grading: Grading, approve: Approve) -> None:
    feedback = grading.rows[STILL]["feedback"]
    assert all(TRY[name][0] in feedback for name in GATES)
    approve("feedback en.txt", f"{feedback}\n")


def test_a_student_gets_a_page_with_pictures_and_no_scripts(grading: Grading, approve: Approve) -> None:
    page = (grading.pages / "Ann Lee-12.html").read_text(encoding="utf-8")
    assert page.count("<svg xmlns") == 3 and "0 of 11 points" in page and "<script" not in page
    body = page[page.index("<body") :]
    approve("page of Ann Lee.txt", shown_text(re.sub(r"<figure.*?</figure>", "", body, flags=re.DOTALL)))


def test_moodle_canvas_and_gradescope_get_the_points(grading: Grading) -> None:
    assert "Participant 12,Ann Lee,0,11,," in grading.files["moodle"]
    canvas = grading.files["canvas"].splitlines()
    assert canvas[:2] == ["Student,ID,Section,Duet", "Points Possible,,,11"] and "doe,7,,0" in canvas
    result = json.loads(grading.files["gradescope"])
    good = [one for one in result["tests"] if one["name"].startswith("deep/good.py")]
    assert sum(one["score"] for one in good) == 11 and {one["status"] for one in good} == {"passed"}


def test_progress_counts_the_files_and_cannot_be_a_formula(grading: Grading) -> None:
    count = len(grading.rows)
    assert f"{count}/{count} " in grading.progress and f"\n'{FORMULA}" not in grading.progress
