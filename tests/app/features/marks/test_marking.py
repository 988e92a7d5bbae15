"""LawMarks for laws and reports that are wrong in every way that we could think of: each costs its own row, and leaves nothing behind."""

import csv
import json
import os
import re
import secrets
import socket
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from functools import partial
from pathlib import Path
from textwrap import dedent
from types import SimpleNamespace

import pytest

import app
from app.__main__ import run_command as main
from app.features.custom_law.arena import PIECES
from app.features.custom_law.examination import examine
from app.features.custom_law.law_limits import LawLimits
from app.features.custom_law.trials import GATES, TRIALS, TRY
from app.features.lab_report.lab_report import Done, lab_bytes
from app.features.lab_report.report_html import StepRecord, read_records, records_html
from app.features.lessons.loading import load_lessons
from app.features.lessons.progress import StepProgress
from app.features.marks.fence import FenceLimits
from app.features.marks.graded_file import REPORT
from app.features.marks.marked import LawMarks, marked, take
from app.i18n.catalogue import words_of
from app.plots.curve_chart import COLUMNS
from controllers.errors import LazyText
from scenes.files import csv_cell
from tests.app.features.custom_law.helpers import PAPER, write
from tests.app.runtime.processes import until

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(os.name != "posix", reason="the files fork and send signals"),
]

LAW = "def law(situation):\n    return situation.nominal\n"
FORKS = "import os, time\nfor _ in range(9):\n    os.fork()\ntime.sleep(60)\n"
LEAVES = (
    "import os, time\nif not os.fork():\n    os.setsid()\n    if not os.fork():\n        time.sleep(600)\n    os._exit(0)\n"
    "os.wait()\n1 / 0\n"
)

TOO_MANY = "more than 48 processes|BlockingIOError"
"""Seen from outside, or by the file itself."""

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
"""Name → text, and what is said to it, as a regular expression."""


@pytest.fixture(autouse=True)
def _nothing_is_left(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    # Tests of other files start fences at the same time.
    mine, made = secrets.token_hex(8), secrets.token_hex
    monkeypatch.setattr(
        "app.features.marks.fence.secrets", SimpleNamespace(token_hex=lambda count: mine + made(count))
    )
    yield
    # What was killed takes a moment to end on a busy machine.
    until(
        lambda: (
            not any(
                name.isdecimal() and f"DUET_FENCE={mine}".encode() in environment(name)
                for name in os.listdir("/proc")
            )
        )
    )


def environment(process: str) -> bytes:
    try:
        return Path("/proc", process, "environ").read_bytes()
    except OSError:
        return b""


def quick(text: str, **limits: object) -> LawMarks:
    return marked("law.py", text.encode(), FenceLimits(**({"law": LawLimits(load=0.5)} | limits)))  # pyright: ignore[reportArgumentType]


def full() -> bool:
    return quick("1/0").isolation == "full"


@pytest.mark.thorough
def test_every_file_costs_one_row(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "in"
    (folder / "deep" / "__pycache__").mkdir(parents=True)
    (folder / "folder.py").mkdir()
    write(folder / "deep" / "good.py", PAPER)
    write(folder / "=1+1.py", "1/0")
    for name, (text, _) in NASTY.items():
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "bytes.py").write_bytes(b"\xff\xfe\x00def")
    with (folder / "huge.py").open("wb") as file:
        file.truncate(2**30)
    with (folder / "huge.html").open("wb") as file:
        file.truncate(2**30)
    (folder / "empty.html").write_text("<p>nothing</p>", encoding="utf-8")
    (folder / "loop.py").symlink_to("loop.py")
    (folder / "around").symlink_to("..")
    os.mkfifo(folder / "pipe.py")
    (folder / "deep" / "__pycache__" / "no.py").write_text(LAW, encoding="utf-8")
    lesson = next(lesson for lesson in load_lessons().lessons if lesson.id == "hold")
    report = lab_bytes(
        [Done(lesson, 0, StepProgress(choice=1)), Done(lesson, 2, StepProgress(attempts=2, passed=True))],
        "de",
    )
    (folder / "report.html").write_bytes(report)

    zero = "Ann Lee_12_assignsubmission_file_/my_law.py"
    (folder / zero).parent.mkdir()
    write(folder / zero, "def law(s):\n    # It stands still.\n    return 0.0 * s.nominal")

    table, pages = tmp_path / "marks.csv", tmp_path / "pages"
    files = {name: tmp_path / name for name in ("moodle", "canvas", "gradescope")}
    more = [word for name, path in files.items() for word in (f"--{name}", str(path))]
    weights = ["--points", "3", "1", "3", "2", "1", "1"]
    command = [
        "grade",
        str(folder),
        "--csv",
        str(table),
        "--jobs",
        "2",
        "--seconds",
        "150",
        "--feedback",
        str(pages),
    ]
    assert main([*command, *more, *weights]) == 0
    with table.open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    assert header == [
        "name",
        "kind",
        *TRIALS,
        *REPORT,
        "points",
        "reason",
        "student",
        "id",
        "maximum",
        "feedback",
    ]
    others = "=1+1.py bytes.py deep/good.py empty.html huge.html huge.py loop.py pipe.py report.html"
    assert [row[0].removeprefix("'") for row in rows] == sorted([*others.split(), zero, *NASTY])
    by_name = {row[0]: dict(zip(header, row, strict=True)) for row in rows}
    assert [by_name["deep/good.py"][name] for name in TRIALS] == ["pass"] * 6 and by_name["deep/good.py"][
        "points"
    ] == "11"
    assert [by_name[zero][name] for name in TRIALS] == ["fail", "fail", "fail", "pass", "pass", "pass"]
    assert [by_name[zero][key] for key in ("points", "maximum", "student", "id")] == [
        "0",
        "11",
        "Ann Lee",
        "12",
    ]
    assert "on line 3, in “return 0.0 * s.nominal”" in by_name[zero]["feedback"]
    assert (
        all(TRY[name][0] in by_name[zero]["feedback"] for name in GATES)
        and "Lesson 6 shows it." in by_name[zero]["feedback"]
    )
    page = (pages / "Ann Lee-12.html").read_text(encoding="utf-8")
    assert page.count("<svg xmlns") == 3 and "0 of 11 points" in page and "<script" not in page
    assert "Participant 12,Ann Lee,0,11,," in files["moodle"].read_text(encoding="utf-8")
    canvas = files["canvas"].read_text(encoding="utf-8").splitlines()
    assert canvas[:2] == ["Student,ID,Section,Duet", "Points Possible,,,11"] and "doe,7,,0" in canvas
    result = json.loads(files["gradescope"].read_text(encoding="utf-8"))
    good = [one for one in result["tests"] if one["name"].startswith("deep/good.py")]
    assert sum(one["score"] for one in good) == 11 and {one["status"] for one in good} == {"passed"}
    said = {name: text for name, (_, text) in NASTY.items()}
    said |= {
        "'=1+1.py": "division by zero",
        "bytes.py": "cannot be read as text",
        "loop.py": "a link",
        "pipe.py": "a pipe",
    }
    said |= {"huge.py": "larger than 1", "huge.html": "larger than 33", "empty.html": "is not a lab report"}
    assert {
        name: by_name[name]["reason"]
        for name, text in said.items()
        if not re.search(text, by_name[name]["reason"])
    } == {}
    assert all(by_name[name]["reason"] for name in by_name if name != "deep/good.py")
    assert [by_name["report.html"][key] for key in ("kind", *REPORT, "points")] == [
        "report",
        "2",
        "1",
        "0",
        "1",
        "1",
        "2",
        "1",
    ]
    progress = capfd.readouterr().err
    assert f"{len(rows)}/{len(rows)} " in progress and "\n'=1+1.py" not in progress


@pytest.mark.thorough
@pytest.mark.parametrize("isolated", [True, False])
def test_all_that_a_file_has_started_goes_with_it(isolated: bool) -> None:
    # `_nothing_is_left` looks for what remains.
    marks = quick(FORKS, isolated=isolated, law=LawLimits(load=30.0))
    assert re.search(TOO_MANY, f"{marks.ended} {marks.verdicts}")
    assert len(quick(LEAVES, isolated=isolated).verdicts) == 6


def test_less_isolation_is_said_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("app.features.marks.fence.FenceLimits", partial(FenceLimits, isolated=False))
    for name in ("a.py", "b.py"):
        (tmp_path / name).write_text("1/0", encoding="utf-8")
    assert main(["grade", str(tmp_path), "--csv", str(tmp_path / "marks.csv")]) == 0
    assert capfd.readouterr().err.count("nothing but time, memory and number of processes is limited") == 1


def test_memory_and_time_of_the_whole_tree() -> None:
    many = "import os, time\nfor _ in range(4):\n    os.fork()\na = bytearray(b'x') * (100 * 2**20)\ntime.sleep(60)\n"
    assert (
        quick(many, memory=300 * 2**20, law=LawLimits(load=30.0)).ended
        == "it took more than 300 MiB of memory"
    )
    marks = quick("import time\ntime.sleep(60)\n", seconds=2.0, law=LawLimits(load=30.0))
    assert marks.ended == "it did not end within 2 s" and marks.verdicts == {}
    assert words_of("de")(marks.ended) == "es endete nicht innerhalb von 2 s"


LARGE = "import sys, time\na = bytearray(b'x') * (400 * 2**20)\ntime.sleep(200)\n"
HIDDEN = {
    "shared": "import mmap\na = mmap.mmap(-1, 400 * 2**20)\nfor _ in range(25):\n    a.write(b'x' * 2**24)\n",
    "another environment": f"import subprocess, sys\nsubprocess.Popen([sys.executable, '-c', {LARGE!r}], env={{}})\n",
    "an orphan": "import os, sys\nif not os.fork():\n    if not os.fork():\n        "
    f"os.execve(sys.executable, [sys.executable, '-c', {LARGE!r}], {{}})\n    os._exit(0)\n",
    "without a name": "import os\nfiles = [os.memfd_create('a') for _ in range(25)]\nfor one in files:\n    os.write(one, b'x' * 2**24)\n",
}
"""Where a file may keep memory → a text that keeps 400 MiB there."""


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere nothing is measured")
@pytest.mark.parametrize("place", HIDDEN)
@pytest.mark.parametrize("isolated", [True, False])
def test_no_memory_is_hidden(place: str, isolated: bool) -> None:
    text = f"{HIDDEN[place]}import time\ntime.sleep(200)\n"
    marks = quick(text, memory=300 * 2**20, isolated=isolated, seconds=120.0, law=LawLimits(load=100.0))
    assert marks.ended == "it took more than 300 MiB of memory"


@pytest.fixture(params=[0, 4], ids=["a core of its own", "a busy core"])
def busy(request: pytest.FixtureRequest) -> Iterator[None]:
    """What is started, and this process, share one core with a number of others that never rest."""
    if not request.param:
        yield
        return
    if not hasattr(os, "sched_setaffinity"):
        pytest.skip("this system does not bind processes to a core")
    cores = os.sched_getaffinity(0)
    with ExitStack() as opened:
        opened.callback(os.sched_setaffinity, 0, cores)
        os.sched_setaffinity(0, {min(cores)})
        for _ in range(request.param):
            # By its id, whatever comes.
            opened.callback(subprocess.Popen([sys.executable, "-c", "while True: pass"]).kill)
        yield


@pytest.mark.thorough
def test_a_law_that_changes_the_clock_is_not_quick(busy: None) -> None:
    clock = """
    import time
    import app.features.custom_law.law_file

    real = time.thread_time
    app.features.custom_law.law_file.perf_counter = time.perf_counter = time.monotonic = time.process_time = lambda: 0.0
    """
    for wait in ("time.sleep(0.003)", "while real() < end: pass"):
        slow = PAPER.replace(
            "(situation):\n", f"(situation):\n        end = real() + 0.003\n        {wait}\n", 1
        )
        verdict = next(examine(Path("law.py"), only=("quick",), text=dedent(clock + slow).encode()))
        assert isinstance(verdict.reason, LazyText) and isinstance(
            median := verdict.reason.parts["median"], float
        )
        assert not verdict.passed and median > 2.0, wait


def test_a_law_reaches_nothing_of_ours(tmp_path: Path) -> None:
    if not full():
        pytest.skip("this system gives no namespaces to a process")
    other, mine = tmp_path / "other.py", tmp_path / "mine"
    other.write_text("secret", encoding="utf-8")
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        tries = (
            f"open({str(mine)!r}, 'w')",
            f"open({app.__file__!r}, 'a')",
            f"open({str(other)!r})",
            f"os.listdir({str(Path.home())!r} + '/.config')",
            "open('/etc/passwd')",
            f"__import__('socket').create_connection(('127.0.0.1', {port}), 1.0)",
            "open(f'/proc/{os.getppid()}/mem', 'r+b')",
            "open(f'/proc/{os.getppid()}/fd/1', 'w')",
            f"os.kill({os.getpid()}, 0)",
            "os.setuid(0)",
        )
        lines = ["import os", "failed = []"]
        for one in tries:
            lines += [
                "try:",
                f"    {one}",
                "except OSError as error:",
                "    failed.append(type(error).__name__)",
            ]
        lines += [
            "open('here', 'w').write(os.environ['HOME'])",
            "raise RuntimeError(failed, os.getcwd() == os.environ['HOME'])",
        ]
        marks = marked("law.py", "\n".join(lines).encode())
    refused, gone = "PermissionError", "ProcessLookupError"
    nothing = "FileNotFoundError"
    errors = [nothing, "OSError", nothing, nothing, nothing, "OSError", refused, refused, gone, "OSError"]
    assert f"({errors}, True)" in marks.verdicts["smooth"].reason
    assert not mine.exists()


def test_a_curve_that_a_file_has_made_up_is_left_out() -> None:
    assert PIECES == COLUMNS
    good = {"quantity": "d", "seconds": 8.0, "limit": 0.15, "lines": {"": [0.1] * PIECES}}
    of_lines = ({"lines": {"": [1.0]}}, {"lines": {"": ["<b>"] * PIECES}})
    for change in ({}, {"quantity": "x"}, {"seconds": float("nan")}, {"limit": "a"}, *of_lines):
        marks = LawMarks()
        said = {
            "name": "smooth",
            "passed": False,
            "reason": "no",
            "as_template": True,
            "curve": good | change,
        }
        with suppress(ValueError):
            take(marks, said)
        (verdict,) = marks.verdicts.values()
        assert (verdict.name, verdict.passed, verdict.reason) == ("smooth", False, "no") and marks.as_template
        assert (verdict.curve is not None) is (change == {})


def test_a_cell_is_no_formula() -> None:
    starts = ("=1", "+1", "-1", "@a", "\t=1", " =1", "\n@", "＝1", "＋1", "－1", "＠a")
    assert all(csv_cell(text).startswith("'") for text in starts)
    assert (
        csv_cell("a\nb\x1b[2J\u202e") == "a b [2J"
        and csv_cell(5) == "5"
        and len(csv_cell("x" * 9999)) == 2000
    )


RECORDS = [StepRecord("hold", "push", 2, True, None, 0), StepRecord("hold", "break", None, None, False, 3)]


def test_a_record_comes_back_and_shows_nothing() -> None:
    page = f"<p>{records_html(RECORDS)}</p>".encode()
    assert list(read_records(page)) == RECORDS
    assert records_html([]) == ""


@pytest.mark.parametrize(
    "steps",
    [
        *(
            [["hold", "push", True, None, None, 0]],
            [["hold", "push", 1, 1, None, 0]],
            [["hold", "push", 1, True, None, -1]],
        ),
        *(
            [["=1", "push", 1, True, None, 0]],
            [["hold", "push"]],
            "steps",
            [["hold", "push", 1, True, None, 0]] * 2,
            [[]] * 501,
        ),
        json.loads("[" * 500 + "]" * 500),
    ],
)
def test_a_damaged_record_is_refused(steps: object) -> None:
    page = str(records_html(RECORDS))
    good = json.dumps(
        [[r.lesson, r.step, r.prediction, r.right, r.passed, r.attempts] for r in RECORDS]
    ).replace('"', "&#34;")
    assert good in page
    with pytest.raises(ValueError, match="its record"):
        read_records(page.replace(good, json.dumps(steps).replace('"', "&#34;")).encode())


def test_nothing_to_grade(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for arguments in (["."], ["no"], [".", "--jobs", "-1"], [".", "--points", "1", "2"]):
        assert main(["grade", *arguments]) == 2
    (tmp_path / "a.py").touch()
    assert main(["grade", str(tmp_path), "--csv", str(tmp_path / "no" / "a.csv")]) == 2
    assert capsys.readouterr().err.count("lwr-duet: ") == 5


def test_a_place_that_cannot_be_written_is_named_before_the_first_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.features.marks.command._graded", lambda *given: pytest.fail("a file was graded"))
    law = tmp_path / "a.py"
    law.touch()
    for option in ("csv", "moodle", "canvas", "gradescope"):
        for place in (tmp_path, *(Path("/proc/x"),) * (sys.platform == "linux")):
            assert main(["grade", str(tmp_path), f"--{option}", str(place)]) == 2
            assert f"{option} = {place}: cannot be written" in capsys.readouterr().err
    assert main(["grade", str(tmp_path), "--csv", str(tmp_path / "marks.csv"), "--feedback", str(law)]) == 2
    assert f"{law} is a file; give a folder" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [law]


def test_a_damaged_archive_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = tmp_path / "class.zip"
    for method, place, damage in (
        # What LZMA begins with, here with properties that there are not; and the sizes of a part in the directory.
        (zipfile.ZIP_LZMA, b"a.py", bytes((9, 4, 5, 0, 255))),
        (zipfile.ZIP_STORED, b"PK\x01\x02", b"\0" * 16 + 2 * (2**20).to_bytes(4, "little")),
    ):
        with zipfile.ZipFile(given, "w", method) as archive:
            archive.writestr("a.py", LAW)
        data = given.read_bytes()
        at = data.index(place) + 4
        given.write_bytes(data[:at] + damage + data[at + len(damage) :])
        assert main(["grade", str(given), "--csv", str(tmp_path / "a.csv")]) == 2
        assert "is no folder and no ZIP file" in capsys.readouterr().err
