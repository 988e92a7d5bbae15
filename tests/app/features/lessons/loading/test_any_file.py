"""Any text gives a lesson or a mistake with its line; pipes, devices and folders are named, never read."""

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.features.lessons.lesson import Lesson
from app.features.lessons.loading import load_lessons
from tests.app.features.lessons.helpers import SMALL

pytestmark = pytest.mark.slow

LINES: list[str] = list[str](SMALL.splitlines(keepends=True))
EXTRA = (
    "```\n",
    "```duet\n",
    "## X\n",
    "### Hints\n",
    "[challenge]\n",
    "[[why]]\n",
    "= 1\n",
    "{measured:d}\n",
    "1. x\n",
)


@st.composite
def broken(draw: st.DrawFn) -> str:
    lines = list(LINES)
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(lines) - 1))
        match draw(st.sampled_from(("lose", "double", "swap", "spoil", "insert", "cut"))):
            case "lose":
                del lines[at]
            case "double":
                lines.insert(at, lines[at])
            case "swap":
                other = draw(st.integers(0, len(lines) - 1))
                lines[at], lines[other] = lines[other], lines[at]
            case "spoil":
                i, what = draw(st.integers(0, len(lines[at]))), draw(st.text(max_size=3))
                lines[at] = lines[at][:i] + what + lines[at][i + draw(st.integers(0, 3)) :]
            case "insert":
                lines.insert(at, draw(st.sampled_from(EXTRA)))
            case _:
                del lines[max(at, 1) :]
        if not lines:
            return ""
    return "".join(lines)


def load_text(folder: Path, text: str) -> tuple[Lesson | None, int]:
    (folder / "01-small.md").write_bytes(text.encode("utf-8", "surrogatepass"))
    book = load_lessons(folder)
    assert (len(book.lessons) == 1) != bool(book.problems)
    return (book.lessons[0], 0) if book.lessons else (None, book.problems[0].line)


@pytest.mark.thorough
@given(text=broken())
@settings(max_examples=200)
def test_a_broken_file_never_raises_and_is_named_with_a_line(
    tmp_path_factory: pytest.TempPathFactory, text: str
) -> None:
    lesson, line = load_text(tmp_path_factory.getbasetemp(), text)
    if lesson is None:
        assert 1 <= line <= max(text.count("\n") + text.count("\r") + 2, 1)
    else:
        assert lesson.steps


@given(text=st.text(max_size=200))
def test_any_text_never_raises(tmp_path_factory: pytest.TempPathFactory, text: str) -> None:
    lesson, line = load_text(tmp_path_factory.getbasetemp(), text)
    assert lesson is None and line >= 1


JUNK = st.recursive(
    st.one_of(st.booleans(), st.integers(-(10**6), 10**6), st.floats(-1e9, 1e9), st.sampled_from(["", "yours", "x", "n"])),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["a", "n", "script", "ball", "from"]), inner, max_size=2),
    max_leaves=5,
)  # fmt: skip
KEYS = ("id", "settings", "start", "input", "seconds", "camera", "plots", "numbers", "marks", "right", "expects", "ratio", "measure",
        "why", "challenge", "attempt")  # fmt: skip


def toml(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(inner)}" for key, inner in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return repr(value).replace("'", '"')


@given(key=st.sampled_from(KEYS), value=JUNK)
@settings(max_examples=200)
def test_any_value_for_any_key_is_accepted_or_named(
    tmp_path_factory: pytest.TempPathFactory, key: str, value: object
) -> None:
    text = SMALL[SMALL.index("## Second") :].replace(
        'id = "second"\ninput = "yours"\nseconds = 1.0', f"{key} = {toml(value)}"
    )
    text = text.replace(
        '\n[[measure]]\nname = "smallest_distance"\n',
        "" if key == "measure" else '\n[[measure]]\nname = "gain_step"\n',
    )
    lesson, line = load_text(tmp_path_factory.getbasetemp(), "# T\n\nG\n\n" + text)
    assert lesson is not None or 1 <= line <= 20


ROOT = Path(__file__).parents[5]

CODE = """
import sys
from dataclasses import dataclass
from pathlib import Path
from app.__main__ import run_command as main
from app.features.lessons.library import notes_of
from app.features.lessons.loading import load_lessons
folder, *commands = sys.argv[1:]
book = load_lessons(Path(folder), "de")
print(*(lesson.id for lesson in book.lessons))
print(*notes_of(book))
print(*(main(command.split()) for command in commands))
print(*(str(problem) for problem in book.problems), sep="\\n")
"""


@dataclass(frozen=True)
class Loaded:
    """Output of a process that loaded a folder and tried commands. `notes`: ids of lessons with notes."""

    lessons: str
    notes: str
    codes: list[str]
    problems: list[str]


def lay_traps(folder: Path, place: Path) -> list[str]:
    """Commands with names of pipes, devices and folders; such names are also in the written lesson folder."""
    pipe, table = place / "pipe", place / "table"
    for path in (folder, table, folder / "05-folder.md"):
        path.mkdir()
    texts = {
        "01-good": SMALL,
        "01-good.notes": "Notes.",
        "07-inputs": SMALL.replace('input = "nobody"', 'input = { file = "data.csv" }'),
        "08-inputs": SMALL.replace('input = "nobody"', 'input = { file = "pipe.csv" }'),
        "09-picture": SMALL.replace("Move the ball.\n", "Move the ball.\n\n![a loop](loop.svg)\n"),
        "10-zero": SMALL.replace('input = "nobody"', 'input = { file = "a\\u0000" }'),
        "11-last": SMALL,
    }
    for name, text in texts.items():
        (folder / f"{name}.md").write_text(text, encoding="utf-8")
    (folder / "03-device.md").symlink_to("/dev/zero")
    for name in ("04-endless.md", "data.csv", "loop.svg"):
        (folder / name).symlink_to(name)
    pipes = (folder / name for name in ("01-good.de.md", "02-pipe.md", "02-pipe.notes.md", "pipe.csv"))
    for path in (*pipes, pipe, table / "sweep.csv"):
        os.mkfifo(path)
    return [
        *(f"run --seconds 0.1 --inputs {path}" for path in (pipe, "/dev/zero", place)),
        *(f"run --seconds 0.1 --scene imitation --bvh {path}" for path in (pipe, place)),
        *(f"run --seconds 0.1 --law-file {path}" for path in (pipe, place)),
        f"run --seconds 0.1 --csv {pipe}",
        f"law-test {pipe}",
        *(f"serve --no-open --port 0 --{option} {pipe}" for option in ("law-file", "bvh", "lessons")),
        *(f"bench --compare {path}" for path in (pipe, "/dev/zero", place)),
        f"sweep --over n=1:2 --seconds 0.1 --out {table}",
    ]


@pytest.fixture(scope="module")
def loaded(tmp_path_factory: pytest.TempPathFactory) -> Loaded:
    """Result of a separate process, which is stopped if it waits."""
    place = tmp_path_factory.mktemp("traps")
    folder = place / "lessons"
    commands = lay_traps(folder, place)
    done = subprocess.run(
        [sys.executable, "-c", CODE, str(folder), *commands],
        capture_output=True,
        encoding="utf-8",
        timeout=100,
        check=False,
        cwd=ROOT,
    )
    assert done.returncode == 0, done.stderr
    found, notes, codes, *problems = done.stdout.splitlines()
    assert len(codes.split()) == len(commands)
    return Loaded(found, notes, codes.split(), problems)


pipes_have_names = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names")


@pytest.mark.thorough
@pipes_have_names
def test_lessons_beside_pipes_devices_and_folders_still_load(loaded: Loaded) -> None:
    assert loaded.lessons == "good last" and loaded.notes == "good"


@pytest.mark.thorough
@pipes_have_names
def test_pipes_devices_and_folders_are_named_with_the_reason(loaded: Loaded) -> None:
    named = {
        "01-good.de": "a pipe",
        "02-pipe": "a pipe",
        "03-device": "a device",
        "04-endless": "cannot be read",
        "05-folder": "a folder",
        "07-inputs": "cannot be read",
        "08-inputs": "a pipe",
        "09-picture": "'loop.svg' cannot be read",
        "10-zero": "outside the folder",
    }
    for name, reason in named.items():
        (problem,) = [problem for problem in loaded.problems if problem.startswith(f"{name}.md, line")]
        assert reason in problem
    assert len(loaded.problems) == len(named)


@pytest.mark.thorough
@pipes_have_names
def test_no_command_waits_for_a_pipe_or_reads_a_device(loaded: Loaded) -> None:
    assert set(loaded.codes) == {"2"}
