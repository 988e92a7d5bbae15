"""What is no file in a folder of lessons, or beside one, is named and left out; nothing waits for it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.lessons.helpers import SMALL

ROOT = Path(__file__).parents[3]

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names")

LOAD = """
import sys
from pathlib import Path
from app.lessons.loading import load_lessons, load_notes
folder = Path(sys.argv[1])
book = load_lessons(folder, "de")
print(*(lesson.id for lesson in book.lessons))
print(*load_notes(folder))
print(*(str(problem) for problem in book.problems), sep="\\n")
"""


def answers(code: str, *arguments: str) -> list[str]:
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], capture_output=True, encoding="utf-8", timeout=100, check=False, cwd=ROOT
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_the_other_lessons_still_load(tmp_path: Path) -> None:
    def lesson(name: str, text: str = SMALL) -> None:
        (tmp_path / f"{name}.md").write_text(text, encoding="utf-8")

    lesson("01-good")
    (tmp_path / "01-good.notes.md").write_text("Notes.", encoding="utf-8")
    os.mkfifo(tmp_path / "01-good.de.md")
    os.mkfifo(tmp_path / "02-pipe.md")
    os.mkfifo(tmp_path / "02-pipe.notes.md")
    (tmp_path / "03-device.md").symlink_to("/dev/zero")
    (tmp_path / "04-endless.md").symlink_to("04-endless.md")
    (tmp_path / "05-folder.md").mkdir()
    lesson("06-huge", SMALL + " " * 200_000)
    (tmp_path / "data.csv").symlink_to("data.csv")
    lesson("07-inputs", SMALL.replace('input = "nobody"', 'input = { file = "data.csv" }'))
    os.mkfifo(tmp_path / "pipe.csv")
    lesson("08-inputs", SMALL.replace('input = "nobody"', 'input = { file = "pipe.csv" }'))
    (tmp_path / "loop.svg").symlink_to("loop.svg")
    lesson("09-picture", SMALL.replace("Move the ball.\n", "Move the ball.\n\n![a loop](loop.svg)\n"))
    lesson("10-zero", SMALL.replace('input = "nobody"', 'input = { file = "a\\u0000" }'))
    lesson("11-last")
    found, notes, *problems = answers(LOAD, str(tmp_path))
    assert found == "good last" and notes == "good"
    named = {
        "01-good.de": "a pipe",
        "02-pipe": "a pipe",
        "03-device": "a device",
        "04-endless": "cannot be read",
        "05-folder": "a folder",
        "06-huge": "larger than 200 kB",
        "07-inputs": "cannot be read",
        "08-inputs": "a pipe",
        "09-picture": "'loop.svg' cannot be read",
        "10-zero": "outside the folder",
    }
    for name, reason in named.items():
        (problem,) = [problem for problem in problems if problem.startswith(f"{name}.md, line")]
        assert reason in problem
    assert len(problems) == len(named)


MAIN = """
import sys
from app.cli.main import main
for line in sys.argv[1:]:
    print(main(line.split()))
"""


def test_a_command_does_not_wait_for_a_pipe_or_read_a_device(tmp_path: Path) -> None:
    pipe, table = tmp_path / "pipe", tmp_path / "table"
    os.mkfifo(pipe)
    table.mkdir()
    os.mkfifo(table / "sweep.csv")
    commands = [
        *(f"run --seconds 0.1 --inputs {path}" for path in (pipe, "/dev/zero", tmp_path)),
        *(f"run --seconds 0.1 --scene imitation --bvh {path}" for path in (pipe, tmp_path)),
        *(f"run --seconds 0.1 --law-file {path}" for path in (pipe, tmp_path)),
        f"run --seconds 0.1 --csv {pipe}",
        f"law-test {pipe}",
        f"serve --no-open --port 0 --law-file {pipe}",
        f"serve --no-open --port 0 --bvh {pipe}",
        f"serve --no-open --port 0 --lessons {pipe}",
        *(f"bench --compare {path}" for path in (pipe, "/dev/zero", tmp_path)),
        f"sweep --over n=1:2 --seconds 0.1 --out {table}",
    ]
    assert answers(MAIN, *commands) == ["2"] * len(commands)
