"""Any text at all is a lesson or a mistake with a line of its own."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.lessons.lesson import Lesson
from app.lessons.loading import load_lessons
from tests.lessons.helpers import SMALL

LINES: list[str] = list[str](SMALL.splitlines(keepends=True))
EXTRA = ("```\n", "```duet\n", "## X\n", "### Hints\n", "[challenge]\n", "[[why]]\n", "= 1\n", "{measured:d}\n", "1. x\n")


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
    assert len(book.lessons) + len(book.problems) == 1
    return (book.lessons[0], 0) if book.lessons else (None, book.problems[0].line)


@given(text=broken())
@settings(max_examples=400)
def test_a_broken_file_never_raises_and_is_named_with_a_line_of_its_own(
    tmp_path_factory: pytest.TempPathFactory, text: str
) -> None:
    lesson, line = load_text(tmp_path_factory.getbasetemp(), text)
    if lesson is None:
        assert 1 <= line <= max(text.count("\n") + text.count("\r") + 2, 1)
    else:
        assert lesson.steps


@given(text=st.text(max_size=200))
def test_any_text_at_all_never_raises(tmp_path_factory: pytest.TempPathFactory, text: str) -> None:
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
@settings(max_examples=400)
def test_any_value_for_any_key_is_taken_or_named(tmp_path_factory: pytest.TempPathFactory, key: str, value: object) -> None:
    text = SMALL[SMALL.index("## Second") :].replace('id = "second"\ninput = "yours"\nseconds = 1.0', f"{key} = {toml(value)}")
    text = text.replace(
        '\n[[measure]]\nname = "smallest_distance"\n', "" if key == "measure" else '\n[[measure]]\nname = "gain_step"\n'
    )
    lesson, line = load_text(tmp_path_factory.getbasetemp(), "# T\n\nG\n\n" + text)
    assert lesson is not None or 1 <= line <= 20
