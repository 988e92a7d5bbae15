"""A broken lesson is named with its line and the remedy; the other lessons load."""

import re
from pathlib import Path

import pytest

from app.features.lessons.commands import Lessons, lessons
from app.features.lessons.lesson import LessonBook
from app.features.lessons.library import notes_of
from app.features.lessons.loading import load_lessons
from app.text.lesson_text import lesson_html
from tests.app.features.lessons.helpers import SMALL, book_of
from tests.approved import Approve


def said(book: LessonBook) -> str:
    """All problems, one line each."""
    return "".join(f"line {problem.line}: {problem.message}\n" for problem in book.problems)


def line_with(text: str, part: str) -> int:
    (line,) = [number for number, line in enumerate(text.splitlines(), 1) if part in line]
    return line


DRAWING = """
[drawing]
x = "time"
x_range = [0.0, 2.0]
y = "distance"
y_range = [0.0, 0.4]
within = 0.01

[challenge]"""

FORECAST = """[[challenge.forecast]]
name = "smallest_distance"
settings = { n = 6.0 }

"""

BARE = re.sub(r"```duet\n.*?```\n", "", SMALL, flags=re.DOTALL)
"""The small lesson's texts, as in a translation."""

CASES = [
    ("# A small lesson", "A small lesson", "A small lesson", "before the title"),
    ("Find out something.\n", "", "# A small lesson", "has no goal"),
    ("scene = \"ball\"", "scene = \"balls\"", 'scene = "balls"', "choose from solo, ball"),
    ("n = 2.0 }", "n = 200.0 }", "n = 200.0", "from 1 to 20"),
    ("n = 2.0 }", "m = 2.0 }", "m = 2.0", "no setting 'm'; did you mean"),
    ("equations = \"31\"", "equations = 31", "equations = 31", "is not a text"),
    ("equations = \"31\"", "equation = \"31\"", 'equation = "31"', "no key 'equation'"),
    ("right = 2", "right = 3", "right = 3", "from 1 to 2"),
    ("right = 2", "", "## First", "right is missing"),
    ("right = 2", "right = two", "right = two", "not TOML"),
    ("expects = [[0.0, 0.05], [0.05, 9.0]]", "expects = [0.1]", "expects = [0.1]", "has 2 answers"),
    ("expects = [[0.0, 0.05], [0.05, 9.0]]", f"expects = [0.1, {10**400}]", "expects = [0.1", "of one kind"),
    ("expects = [[0.0, 0.05], [0.05, 9.0]]", "expects = [[0.2, 0.1], [0.1, 0.2]]", "expects = [[0.2", "low < high"),
    ("plots = [\"distance\"]", "plots = [\"elbow\"]", 'plots = ["elbow"]', "no 'elbow'; choose from distance"),
    ("plots = [\"distance\"]", "plots = [\"distance\", \"error\", \"lambda\", \"rates\"]", 'plots = ["distance",', "at most 3"),
    ("numbers = [\"distance_now\"]", "numbers = [\"smallest_distance\"]", "numbers = [", "choose from distance_now"),
    ("id = \"d\"\nname = \"smallest_distance\"", "id = \"d\"\nname = \"smallest\"", 'name = "smallest"', "choose from activation_formula"),
    ("id = \"d\"", "id = \"D d\"", 'id = "D d"', "small letters"),
    ("compare = [{ n = 4.0 }]", "compare = [{ q = 4.0 }]", "q = 4.0", "no setting 'q'"),
    ("compare = [{ n = 4.0 }]", "compare = 4", "compare = 4", "list of tables"),
    ("choice = 1\n", "choice = 2\n", "choice = 2", "the right one has none"),
    ("at_least = 5.0", "at_least = \"five\"", 'at_least = "five"', "give a number"),
    ("at_least = 5.0", "unit = \"\"", 'name = "setting"', "no bound"),
    ("key = \"n\"", "key = \"nn\"", 'key = "nn"', "no setting 'nn'"),
    ("fails = [\"n\"]", "fails = [\"dm\"]", 'fails = ["dm"]', "choose from n"),
    ("input = \"nobody\"", "input = \"somebody\"", 'input = "somebody"', "choose from autopilot"),
    ("input = \"nobody\"", "input = { script = \"push\", speed = 0.2 }", 'script = "push"', "choose from ball_to"),
    ("input = \"nobody\"", "input = { script = \"ball_to\" }", 'script = "ball_to"', "needs the place 'place'"),
    ("input = \"nobody\"", "input = { script = \"ball_to\", place = 1.0 }", "place = 1.0", "place = 1.0 is not a place; write place ="),
    ("input = \"nobody\"", "input = { script = \"ball_to\", place = \"goal\" }", 'script = "ball_to"', "place = 'goal' is not a place"),
    ("input = \"nobody\"", "input = { script = \"ball_to\", plaice = 1.0 }", "plaice", "no parameter 'plaice'; choose from place,"),
    ("input = \"nobody\"", "input = { script = \"ball_to\", speed = { gap = 1 } }", "ball_to", "speed = {'gap': 1} is not a number"),
    ("input = \"nobody\"", "input = { script = \"ball_too\", place = { a = 1 } }", 'script = "ball_too"', "no script 'ball_too'"),
    ("input = \"nobody\"", "input = { script = \"ball_push\", fast = 1 }", 'script = "ball_push"', "no parameter 'fast'"),
    ("input = \"nobody\"", "input = { file = \"../x.csv\" }", "x.csv", "outside the folder"),
    ("input = \"nobody\"", "input = { file = \"x.csv\" }", "x.csv", "cannot be read"),
    ("input = \"nobody\"", "start = { ball = { from = \"goal\", toward = [0, 0, 0], gap = 0.1 } }", "start = {", "not a direction"),
    ("input = \"nobody\"", "start = { posture = [1.0] }", "start = {", "has 1 angles"),
    ("seconds = 2.0\nplots", "seconds = 2000.0\nplots", "seconds = 2000", "from 0.1 to 60"),
    ("### Predict", "### Prediction", "### Prediction", "choose from Goal"),
    ("### Explain\n\nBecause $x$.\n", "", "## First", "under “### Explain”"),
    ("### Goal\n\nTo see.\n", "", "## First", "under “### Goal”"),
    ("2. Far.", "3. Far.", "3. Far.", "where 2 comes next"),
    ("   > No: {measured:d}.", "", "1. Near.", "has no reply"),
    ("3. Three.", "", "### Hints", "there are 2 hints"),
    ("It was {measured:d}", "It was {measured:dd}", "{measured:dd}", "choose from d"),
    ("It was {measured:d}", "It was {measured:d:2}", "{measured:d:2}", "has 1 comparisons"),
    ("It was {measured:d}", "{table:dd}", "{table:dd}", "choose from d"),
    ("It was {measured:d} at", "{table:d} at", "{table:d}", "line of its own"),
    ("How near? With n = 4 it is {measured:d:1}.", "How near?\n\n{table:d}", "{table:d}", "gives the answer away"),
    ("[challenge]\nseconds = 2.0", "[challenge]\nsearch = \"law\"", 'search = "law"', "choose from"),
    ("[challenge]\nseconds = 2.0", "[challenge]\nnull_motions = true", "null_motions = true", "needs the scene solo"),
    ("name = \"more\"", "name = \"more\"\nforecasts = 0.5", "forecasts = 0.5", "is not a list"),
    ("[[challenge.criterion]]", FORECAST * 5 + "[[challenge.criterion]]", "[[challenge.forecast]]", "at most 4"),
    ("{setting:dm}", "{setting:dmm}", "{setting:dmm}", "did you mean dm"),
    ("{measured:d:1}", "{measured:d}", "How near?", "gives the answer away"),
    ("id = \"second\"", "id = \"first\"", "## Second", "two steps are called first"),
    ("Move the ball.\n", "Move the ball.\n\n```duet\nx = 1\n```\n", "x = 1", "has 2 blocks"),
    ("Move the ball.\n", "Move the ball.\n\n```python\nx\n", "```python", "never closed"),
    ("## Second", "# Second", "# Second", "second title"),
    ("Because $x$.", "Because $x\n\ny$.", "Because $x", "within one paragraph"),
    ("Find out something.", "It costs $5.", "costs $5", "belongs to no formula"),
    ("3. Three.", "3. $Three.", "3. $Three", "belongs to no formula"),
    ("\n[challenge]", DRAWING.replace('"distance"', '"length"'), 'y = "length"', "choose from time, distance"),
    ("\n[challenge]", DRAWING.replace('"distance"', '"time"'), 'y = "time"', "is not a curve"),
    ("\n[challenge]", DRAWING.replace("[0.0, 0.4]", "[0.4, 0.0]"), "y_range = ", "low < high"),
    ("\n[challenge]", DRAWING.replace("x_range = [0.0, 2.0]\n", ""), "[drawing]", "x_range is missing"),
    ("\n[challenge]", DRAWING.replace("within = 0.01", "within = 0.5"), "within = 0.5", "smaller than the axis"),
    ("\n[challenge]", DRAWING.replace("within = 0.01", ""), "[drawing]", "within is missing"),
    ("\n[challenge]", DRAWING.replace("within", 'truth = "formula"\nwithin'), 'truth = "formula"', "only for the activation"),
    ("\n[challenge]", DRAWING.replace("within", "colour = 1\nwithin"), "colour = 1", "no key 'colour' in drawing; choose from x, y"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("old", "new", "where", "message"), CASES, ids=[case[1][:30] or case[3] for case in CASES]
)
def test_a_mistake_is_named_with_its_line_and_the_remedy(
    tmp_path: Path, old: str, new: str, where: str, message: str
) -> None:
    assert SMALL.count(old) >= 1
    text = SMALL.replace(old, new, 1)
    (tmp_path / "02-good.md").write_text(SMALL, encoding="utf-8")
    book = book_of(tmp_path, text)
    assert [lesson.id for lesson in book.lessons] == ["good"]
    (problem,) = book.problems
    assert problem.file == "01-small.md" and message in problem.message
    if where.startswith("## "):
        # A missing part has no line: the line of the step or of its block is right, too.
        assert line_with(text, where) <= problem.line <= line_with(text, where) + 4
    else:
        assert where in text.splitlines()[problem.line - 1]


def test_all_mistakes_of_a_file_are_named_at_once(tmp_path: Path, approve: Approve) -> None:
    mistakes = {
        'equations = "31"': "equation = 31",
        "right = 2": "right = 3",
        "   > No: {measured:d}.": "",
        'plots = ["distance"]': 'plots = ["elbow"]',
        "at_least = 5.0": 'at_least = "five"',
        "3. Three.": "",
        "It was {measured:d} at {setting:dm}.": "It was {measured:x} at {setting:y}.",
        'input = "yours"': 'input = "theirs"',
    }
    text = SMALL
    for old, new in mistakes.items():
        assert text.count(old) == 1
        text = text.replace(old, new)
    # A fault in the lesson's block hides only problems of the steps that need it.
    approve("block.txt", said(book_of(tmp_path, text)))
    book = book_of(tmp_path, text.replace("equation = 31", 'equations = "31"'))
    lines = [problem.line for problem in book.problems]
    assert len(lines) == len(mistakes) and lines == sorted(lines)
    approve("mistakes.txt", said(book))


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("01_small.md", SMALL.encode(), "is like 01-redundancy.md"),
        ("01-small.fr.md", SMALL.encode(), "choose from de, sl"),
        ("03-small.de.md", SMALL.encode(), "which is not there"),
        ("01-small.md", b"# T\n\xff\xfe\n", "UTF-8"),
        ("01-small.md", b"# T\n" + b"x" * 200_000, "larger than 200 kB"),
        ("01-small.md", b"", "no title"),
        ("01-small.md", b"# T\ngoal\n", "no step"),
        ("01-small.md", b"# T\ngoal\n\n```duet\n" + b"a = " + b"[" * 5000 + b"\n```\n## S\n", ""),
    ],
)
def test_files_that_are_not_lessons_are_named(
    tmp_path: Path, name: str, content: bytes, message: str
) -> None:
    (tmp_path / "02-good.md").write_text(SMALL, encoding="utf-8")
    (tmp_path / name).write_bytes(content)
    book = load_lessons(tmp_path)
    assert [lesson.id for lesson in book.lessons] == ["good"]
    assert len(book.problems) == 1 and book.problems[0].file == name and message in book.problems[0].message


def test_folders_without_lessons_and_repeated_numbers_are_named(tmp_path: Path) -> None:
    assert "README.md" in load_lessons(tmp_path).problems[0].message
    assert "cannot be read" in load_lessons(tmp_path / "none").problems[0].message
    book_of(tmp_path)
    book = book_of(tmp_path, name="01-other.md")
    assert len(book.lessons) == 1 and "same number" in book.problems[0].message


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("2. Far.", "2. Weit.\n   > Ja.\n3. Sehr weit.", "has 3 answers"),
        ("### Goal\n\nMove it.\n", "", "### Goal"),
        ("## Second", "## Zweitens\n\n### Goal\n\nx\n\n### Do\n\nx\n\n## Drittens", "has 3 steps"),
        ("To see.", "Sehen.\n\n```duet\nx = 1\n```", "texts only"),
        ("3. Three.", "", "has 2 hints"),
        ("It was {measured:d}", "Es war {measured:x}", "measures no 'x'"),
    ],
)
def test_a_mismatched_translation_is_named_and_english_is_used(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    book_of(tmp_path)
    assert old in BARE
    (tmp_path / "01-small.de.md").write_text(BARE.replace(old, new, 1), encoding="utf-8")
    book = load_lessons(tmp_path, "de")
    assert book.lessons[0].language == "en"
    assert (
        len(book.problems) == 1
        and book.problems[0].file == "01-small.de.md"
        and message in book.problems[0].message
    )


def test_a_translation_replaces_every_text(tmp_path: Path) -> None:
    book = book_of(tmp_path)
    words = r"(?<![{:\w#])\b(small|something|First|see|near|Near|Far|No|Yes|Run|Because|Raise|One|Two|Three|Second|Move)\b"
    (tmp_path / "01-small.de.md").write_text(re.sub(words, lambda m: f"ü{m[0]}", BARE), encoding="utf-8")
    german = load_lessons(tmp_path, "de")
    assert not german.problems
    lesson, original = german.lessons[0], book.lessons[0]
    step, question, challenge = lesson.steps[0], lesson.steps[0].question, lesson.steps[0].challenge
    assert question and challenge
    texts = [
        lesson.title,
        lesson.goal,
        step.title,
        step.goal,
        step.do,
        step.explain,
        question.text,
        challenge.text,
        *step.hints,
    ]
    texts += [choice.text for choice in question.choices] + [choice.reply for choice in question.choices]
    assert all("ü" in text for text in texts)
    assert step.setup == original.steps[0].setup and step.trials == original.steps[0].trials


def test_notes_without_a_lesson_are_a_problem_and_unreadable_ones_skipped(tmp_path: Path) -> None:
    book = book_of(tmp_path)
    (tmp_path / "01-small.notes.md").write_bytes(b"\xff\xfe")
    (tmp_path / "02-other.notes.md").write_text("x", encoding="utf-8")
    assert [problem.file for problem in load_lessons(tmp_path).problems] == ["02-other.notes.md"]
    assert notes_of(book) == {}
    (tmp_path / "01-small.notes.md").write_text("x", encoding="utf-8")
    assert notes_of(book) == {"small": "x"}


HERE = "Because $x$."
"""Text of the small lesson that a picture may replace."""

PICTURE = "![x](a.svg)"

NO_PICTURE = "picture.txt"
"""Approved file with the message for a path without a picture beside the lesson."""


@pytest.mark.parametrize(
    ("instead", "text", "message"),
    [
        (HERE, PICTURE, ""),
        (HERE, f"Because\n{PICTURE}\nof it.", ""),
        (HERE, "![x](below/a.png)", ""),
        ("> No: {measured:d}.", f"> No.\n   > {PICTURE}", ""),
        (HERE, "![](a.svg)", "says nothing"),
        (HERE, "![x](b.svg)", "there is no picture"),
        *(
            (HERE, f"![x]({path})", NO_PICTURE)
            for path in ("below", "../a.svg", "/etc/passwd.svg", "link.svg")
        ),
        (HERE, "![x](https://example.org/a.svg)", "there is no picture"),
        (HERE, "![x](01-small.md)", "must be an .svg or .png"),
        (HERE, "![x](large.svg)", "larger than"),
        (HERE, "![x](text.svg)", "is not an SVG"),
        (HERE, "![x](text.png)", "is not a PNG"),
        *(
            (HERE, text, "a line of its own")
            for text in (f"Because {PICTURE}.", f"- {PICTURE}", "![x\n](a.svg)")
        ),
        *((line, f"{line}\n{PICTURE}", "a line of its own") for line in ("1. Near.", "1. One.")),
        ("## First", f"## First {PICTURE}", "a line of its own"),
        ("Find out something.", PICTURE, "a line of its own"),
    ],
)
def test_pictures_must_be_beside_the_lesson_and_displayable(
    tmp_path: Path, instead: str, text: str, message: str, approve: Approve
) -> None:
    folder = tmp_path / "lessons"
    (folder / "below").mkdir(parents=True)
    for path in (tmp_path / "a.svg", folder / "a.svg"):
        path.write_text(
            '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1 1"><path d="M0 0"/></svg>',
            encoding="utf-8",
        )
    (folder / "link.svg").symlink_to(tmp_path / "a.svg")
    (folder / "below" / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    (folder / "large.svg").write_text("x" * 400_000, encoding="utf-8")
    for name in ("text.svg", "text.png"):
        (folder / name).write_text("text", encoding="utf-8")
    assert instead in SMALL
    book = book_of(folder, SMALL.replace(instead, text))
    if message == NO_PICTURE:
        path = text[len("![x](") : -1]
        approve("picture.txt", str(book.problems[0].message).replace(f"'{path}'", "'…'") + "\n")
        return
    if message:
        assert message in book.problems[0].message
        return
    assert not book.problems
    step = book.lessons[0].steps[0]
    assert step.question is not None
    made = lesson_html(step.explain + "\n\n" + step.question.choices[0].reply, folder)
    assert "![" not in made and ('aria-label="x"' in made or 'alt="x"' in made)


@pytest.mark.parametrize("ending", ["de", "notes"])
def test_pictures_of_translations_and_notes_are_checked_too(
    tmp_path: Path, ending: str, capsys: pytest.CaptureFixture[str]
) -> None:
    book_of(tmp_path)
    text = BARE.replace(HERE, "![x](gone.svg)") if ending == "de" else "# Notes\n\n![x](gone.svg)\n"
    (tmp_path / f"01-small.{ending}.md").write_text(text, encoding="utf-8")
    assert lessons(Lessons(folder=tmp_path)) == 1
    line = text.splitlines().index("![x](gone.svg)") + 1
    said = f"01-small.{ending}.md, line {line}: there is no picture 'gone.svg' beside the lesson."
    assert said in capsys.readouterr().out
