"""A file's student and value; the marks themselves are in `test_graded_class.py`."""

import csv
import signal
import subprocess
import threading
from pathlib import Path

import pytest

from app.features.custom_law.arena import TrialResult
from app.features.custom_law.trials import TRIALS
from app.features.lab_report.report_html import StepRecord, records_html
from app.features.lessons.loading import load_lessons
from app.features.marks import graded_file
from app.features.marks.fence import FenceLimits
from app.features.marks.graded_file import GradedFile, Student, graded, returned_line, student_of, weights_of
from app.features.marks.mark_files import StudentMarks, feedback_page
from app.features.marks.marked import LawMarks
from app.i18n.catalogue import words_of
from app.runtime.terminal import INTERRUPTED, TERMINATED
from app.settings import Language
from controllers.errors import DuetError, LazyText
from controllers.own_packages import own_command
from tests.approved import Approve, shown_text

*_, BOUNDED, _ = TRIALS


def row_of(path: Path, language: Language = "en") -> GradedFile:
    return graded(path, path.parent, FenceLimits(), threading.Event(), weights_of(()), language)


def test_kind_and_student_of_a_file() -> None:
    names = {
        "Jo/law.py": ("Jo", ""),
        "law.py": ("law", ""),
        "doejo_LATE_5_6_a-1.py": ("doejo", "5"),
        "a_b.py": ("a_b", ""),
    }
    assert {name: student_of(Path(name)) for name in names} == {
        name: Student(*known) for name, known in names.items()
    }
    assert returned_line(b"def law(") == returned_line(b"law = 3") == ()


def test_a_step_in_two_reports_counts_once(tmp_path: Path) -> None:
    first = [StepRecord("hold", "push", 1, None, None, 0), StepRecord("hold", "break", None, None, True, 2)]
    again = [StepRecord("hold", "push", 1, True, None, 0), StepRecord("hold", "break", None, None, True, 1)]
    files: list[GradedFile] = []
    for name, records in (("lab-report.html", first), ("lab-report (1).html", again)):
        (tmp_path / name).write_text(records_html(records), encoding="utf-8")
        files.append(row_of(tmp_path / name))
    laws = [GradedFile(f"{i}.py", "law", Student("Jo", ""), points=i, maximum=6.0) for i in (1.0, 4.0)]
    one, both = StudentMarks(Student("Jo", ""), (files[1],)), StudentMarks(Student("Jo", ""), (*files, *laws))
    assert one.points == 2 and one.maximum == files[1].maximum > 2
    assert (both.points, both.maximum) == (6.0, one.maximum + 6.0)


@pytest.mark.parametrize("language", ["de", "sl"])
def test_the_reason_for_no_points_is_in_the_language(
    language: Language, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ended = LazyText("it did not end within {seconds:g} s", seconds=2.0)
    monkeypatch.setattr(graded_file, "marked", lambda *given: LawMarks(ended=ended))
    for name, said in (
        ("law.py", ended),
        ("report.html", "is not a lab report of Duet, or is from an older version"),
    ):
        (tmp_path / name).touch()
        row = row_of(tmp_path / name, language)
        assert row.reason == words_of(language)(said) != said


def test_full_marks_are_announced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, approve: Approve) -> None:
    (tmp_path / "law.py").touch()
    said: list[str] = []
    for passed in (TRIALS, list(TRIALS)[1:]):
        made = LawMarks({name: TrialResult(name, True, "") for name in passed})
        monkeypatch.setattr(graded_file, "marked", lambda *given, made=made: made)
        said.append(StudentMarks(Student("Jo", ""), (row_of(tmp_path / "law.py", "de"),)).feedback)
    (hold,) = (lesson for lesson in load_lessons().lessons if lesson.id == "hold")
    asked = [
        (step.id, step.question is not None or None, step.challenge is not None or None)
        for step in hold.steps
    ]
    records = [StepRecord("hold", id, 1 if right else None, right, passed, 1) for id, right, passed in asked]
    (tmp_path / "report.html").write_text(records_html(records), encoding="utf-8")
    said.append(row_of(tmp_path / "report.html").feedback)
    approve("full marks.txt", "".join(f"{one}\n" for one in said))


def test_the_template_has_no_points(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, approve: Approve
) -> None:
    made = LawMarks(
        {
            name: TrialResult(name, name != BOUNDED, "no" if name == BOUNDED else "", as_template=True)
            for name in TRIALS
        }
    )
    monkeypatch.setattr(graded_file, "marked", lambda *given: made)
    (tmp_path / "my_law.py").touch()
    row = row_of(tmp_path / "my_law.py")
    assert row.points == 0 and row.maximum == 6
    page = feedback_page(StudentMarks(row.student, (row,)))
    assert "`" not in page and "<code>J_d @ J_d</code>" in page and "<code>lwr-duet new-law</code>" in page
    approve("template reason.txt", f"{row.reason}\n")
    approve("template page.txt", shown_text(page[page.index("<body") :]))


def test_a_full_disk_costs_no_points(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, approve: Approve
) -> None:
    def fails(*given: object) -> LawMarks:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(graded_file, "marked", fails)
    (tmp_path / "law.py").touch()
    with pytest.raises(DuetError) as found:
        row_of(tmp_path / "law.py")
    approve("full disk.txt", f"{found.value}\n")
    (tmp_path / "folder.py").mkdir()
    assert "a folder" in row_of(tmp_path / "folder.py").reason


SLOW_LAW = "import time\n\n\ndef law(situation):\n    time.sleep(0.01)\n    return situation.nominal\n"


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_grading_writes_the_graded_files(
    tmp_path: Path, number: signal.Signals, approve: Approve
) -> None:
    folder, table, worksheet = tmp_path / "in", tmp_path / "marks.csv", tmp_path / "moodle.csv"
    folder.mkdir()
    (folder / "a.html").write_text("<p>no report", encoding="utf-8")
    (folder / "b.py").write_text(SLOW_LAW, encoding="utf-8")
    command = own_command(
        "app.__main__", "grade", str(folder), "--csv", str(table), "--moodle", str(worksheet), "--jobs", "1"
    )
    with subprocess.Popen(
        command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=tmp_path
    ) as grading:
        try:
            assert grading.stderr is not None and grading.stdout is not None
            assert grading.stderr.readline().startswith("1/2 a.html")
            grading.send_signal(number)
            said = grading.stderr.read()
            assert grading.wait(60.0) == (INTERRUPTED if number == signal.SIGINT else TERMINATED)
            assert grading.stdout.read() == ""
        finally:
            grading.kill()
    # Python may repeat the line at which the signal arrived.
    *before, last = said.splitlines()
    approve("interrupted.txt", last.replace(str(table), "marks.csv") + "\n")
    assert before in ([], ["1/2 a.html: 0"])
    with table.open(encoding="utf-8-sig", newline="") as file:
        assert [row[0] for row in csv.reader(file)][1:] == ["a.html"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in", "marks.csv"]
