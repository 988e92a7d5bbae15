"""Lesson files: what a good one gives, and that a broken one is named with its line and nothing else suffers."""

import dataclasses
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
import tyro
from hypothesis import given, settings
from hypothesis import strategies as st

from app.lessons import FOLDER
from app.lessons.check import check_lesson, lessons
from app.lessons.labels import LABELS, label_of
from app.lessons.lesson import HINTS, MOST_NUMBERS, MOST_PLOTS, Lesson
from app.lessons.loading import LANGUAGES, load_lessons, load_notes
from app.lessons.measures import QUANTITIES
from app.lessons.options import Lessons
from app.lessons.scripts import SCRIPTS
from app.lessons.words import WORDS
from controllers.errors import BadSetting
from tests.lessons.helpers import SMALL, book_of, our_book


def line_with(text: str, part: str) -> int:
    """The number of the only line with a part in it."""
    (line,) = [number for number, line in enumerate(text.splitlines(), 1) if part in line]
    return line


# ---- our own ------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("language", LANGUAGES)
def test_all_ten_lessons_load_in_every_language(language: str) -> None:
    """Ten lessons, one after the other, without a problem."""
    book = our_book(language)
    assert [str(problem) for problem in book.problems] == []
    assert [lesson.number for lesson in book.lessons] == list(range(1, 11))
    for lesson in book.lessons:
        translated = (FOLDER / lesson.file.replace(".md", f".{language}.md")).exists()
        assert lesson.language == (language if translated else "en")


def test_every_lesson_is_complete() -> None:
    """A question that is answered by a measurement, a challenge with three hints, and no more in view than can be taken in."""
    for lesson in our_book().lessons:
        assert lesson.goal and lesson.equations and 5 <= lesson.minutes <= 25
        assert any(step.question for step in lesson.steps)
        assert any(step.challenge for step in lesson.steps)
        for step in lesson.steps:
            assert len(step.plots) <= MOST_PLOTS and 1 <= len(step.numbers) <= MOST_NUMBERS
            assert len(step.hints) == (HINTS if step.challenge else 0)
            assert step.measurements
            if step.question:
                wrong = [choice for i, choice in enumerate(step.question.choices) if i != step.question.right]
                assert all(choice.why for choice in wrong), (lesson.id, step.id)
                assert step.explain and "measured:" in "".join(choice.reply for choice in step.question.choices)


def test_every_equation_can_be_drawn() -> None:
    """Whatever stands between dollar signs, in all languages, is understood by what draws equations here."""
    zmath = pytest.importorskip("ziamath").zmath
    found = 0
    for path in sorted(FOLDER.glob("*.md")):
        text = re.sub(r"`[^`]*`", "", re.sub(r"```.*?```", "", path.read_text(encoding="utf-8"), flags=re.DOTALL))
        assert text.replace("$$", "").count("$") % 2 == 0
        for display, inline in re.findall(r"\$\$(.+?)\$\$|\$(.+?)\$", text, flags=re.DOTALL):
            tex = re.sub(r"\\tag\{[^}]*\}", "", display or inline).strip()
            assert "<svg" in zmath.Latex(tex).svg()
            found += 1
    assert found > 150


def test_translations_keep_the_numbers_and_the_equations() -> None:
    """A translation has the same placeholders and the same equations in every step, in whatever order."""
    english = our_book()
    for language in LANGUAGES[1:]:
        translated = [lesson for lesson in our_book(language).lessons if lesson.language == language]
        assert len(translated) >= 3
        for lesson in translated:
            original = english.lessons[english.index(lesson.id)]
            for step, before in zip(lesson.steps, original.steps, strict=True):
                for pattern in (r"\{(?:measured|setting):[^}]*\}", r"\\tag\{[^}]*\}"):
                    assert sorted(set(re.findall(pattern, words_of(step)))) == sorted(set(re.findall(pattern, words_of(before))))
                assert words_of(step) != words_of(before)


def words_of(step: object) -> str:
    """All texts of a step."""
    return repr(dataclasses.astuple(step))  # pyright: ignore[reportArgumentType]


# ---- the document -------------------------------------------------------------------------------------------------------------

README = (FOLDER / "README.md").read_text(encoding="utf-8")


def test_the_example_of_the_readme_is_a_lesson_that_passes_its_check(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What the document tells a teacher to save is what the check accepts."""
    (example,) = re.findall(r"````markdown\n(.*?)\n````\n", README, flags=re.DOTALL)
    assert "01-nearer.md" in README
    (tmp_path / "01-nearer.md").write_text(example, encoding="utf-8")
    assert lessons(Lessons(check=True, folder=tmp_path, out=tmp_path / "check.json")) == 0
    assert "0 went otherwise" in capsys.readouterr().out
    assert tyro.cli(Lessons, args=["--check", "--only", "nearer", "--folder", str(tmp_path)]) == Lessons(
        True, ("nearer",), tmp_path
    )
    assert '"nearer"' in (tmp_path / "check.json").read_text(encoding="utf-8")


def test_the_readme_names_everything_there_is() -> None:
    """Every measurement with its parameters, and every script with its own."""
    for name, quantity in QUANTITIES.items():
        (row,) = [line for line in README.splitlines() if line.startswith(f"| `{name}` |")]
        assert all(parameter in row for parameter in quantity.parameters)
        assert row.rstrip(" |").endswith("live") == quantity.live
    for name, known in SCRIPTS.items():
        (row,) = [line for line in README.splitlines() if line.startswith(f"| `{name}` |")]
        assert all(f"`{field.name}`" in row for field in dataclasses.fields(known.make))


# ---- what can be wrong --------------------------------------------------------------------------------------------------------

CASES = [
    ("# A small lesson", "A small lesson", "A small lesson", "before the title"),
    ("Find out something.\n", "", "# A small lesson", "has no goal"),
    ("scene = \"ball\"", "scene = \"balls\"", 'scene = "balls"', "choose from solo, ball"),
    ("n = 2.0 }", "n = 200.0 }", "n = 200.0", "from 1 to 20"),
    ("n = 2.0 }", "m = 2.0 }", "m = 2.0", "no setting 'm'; choose from"),
    ("equations = \"31\"", "equations = 31", "equations = 31", "is no text"),
    ("equations = \"31\"", "equation = \"31\"", 'equation = "31"', "no key 'equation'"),
    ("right = 2", "right = 3", "right = 3", "from 1 to 2"),
    ("right = 2", "", "## First", "right is missing"),
    ("right = 2", "right = two", "right = two", "no TOML"),
    ("expects = [[0.0, 0.05], [0.05, 9.0]]", "expects = [0.1]", "expects = [0.1]", "has 2 answers"),
    ("expects = [[0.0, 0.05], [0.05, 9.0]]", "expects = [[0.2, 0.1], [0.1, 0.2]]", "expects = [[0.2", "low < high"),
    ("plots = [\"distance\"]", "plots = [\"hand\"]", 'plots = ["hand"]', "no 'hand'; choose from distance"),
    ("plots = [\"distance\"]", "plots = [\"distance\", \"error\", \"lambda\"]", 'plots = ["distance",', "at most 2"),
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
    ("input = \"nobody\"", "input = { script = \"ball_push\", fast = 1 }", 'script = "ball_push"', "no parameter 'fast'"),
    ("input = \"nobody\"", "input = { file = \"../x.csv\" }", "x.csv", "outside the folder"),
    ("input = \"nobody\"", "input = { file = \"x.csv\" }", "x.csv", "cannot be read"),
    ("input = \"nobody\"", "start = { ball = { from = \"goal\", toward = [0, 0, 0], gap = 0.1 } }", "start = {", "no direction"),
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
    ("{setting:dm}", "{setting:dmm}", "{setting:dmm}", "choose from scene"),
    ("{measured:d:1}", "{measured:d}", "How near?", "gives the answer away"),
    ("id = \"second\"", "id = \"first\"", "## Second", "two steps are called first"),
    ("Move the ball.\n", "Move the ball.\n\n```duet\nx = 1\n```\n", "x = 1", "has 2 blocks"),
    ("Move the ball.\n", "Move the ball.\n\n```python\nx\n", "```python", "never closed"),
    ("## Second", "# Second", "# Second", "second title"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "where", "message"), CASES, ids=[case[1][:30] or case[3] for case in CASES])
def test_a_mistake_is_named_with_its_line_and_the_remedy(tmp_path: Path, old: str, new: str, where: str, message: str) -> None:
    """Each mistake alone; a good lesson beside it is not harmed."""
    assert SMALL.count(old) >= 1
    text = SMALL.replace(old, new, 1)
    (tmp_path / "02-good.md").write_text(SMALL, encoding="utf-8")
    book = book_of(tmp_path, text)
    assert [lesson.id for lesson in book.lessons] == ["good"]
    (problem,) = book.problems
    assert problem.file == "01-small.md"
    assert message in problem.message
    if where.startswith("## "):
        # What is missing has no line of its own: that of the step, or of its block, will do.
        assert line_with(text, where) <= problem.line <= line_with(text, where) + 4
    else:
        assert where in text.splitlines()[problem.line - 1]


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("01_small.md", SMALL.encode(), "is like 01-redundancy.md"),
        ("01-small.fr.md", SMALL.encode(), "choose from de, sl"),
        ("03-small.de.md", SMALL.encode(), "which is not there"),
        ("01-small.md", b"# T\n\xff\xfe\n", "UTF-8"),
        ("01-small.md", b"# T\n" + b"x" * 300_000, "larger than"),
        ("01-small.md", b"", "no title"),
        ("01-small.md", b"# T\ngoal\n", "no step"),
        ("01-small.md", b"# T\ngoal\n\n```duet\n" + b"a = " + b"[" * 5000 + b"\n```\n## S\n", ""),
    ],
)
def test_files_that_are_no_lessons_at_all(tmp_path: Path, name: str, content: bytes, message: str) -> None:
    """Wrong names, wrong bytes, nothing in them."""
    (tmp_path / "02-good.md").write_text(SMALL, encoding="utf-8")
    (tmp_path / name).write_bytes(content)
    book = load_lessons(tmp_path)
    assert [lesson.id for lesson in book.lessons] == ["good"]
    assert len(book.problems) == 1 and book.problems[0].file == name and message in book.problems[0].message


def test_an_empty_folder_and_none_are_told(tmp_path: Path) -> None:
    """Nothing to show is a problem with a remedy."""
    assert "README.md" in load_lessons(tmp_path).problems[0].message
    assert "cannot be read" in load_lessons(tmp_path / "none").problems[0].message


def test_the_same_number_twice_is_a_problem(tmp_path: Path) -> None:
    """Two lessons cannot stand at one place."""
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
def test_a_translation_that_does_not_fit_is_named_and_english_stays(tmp_path: Path, old: str, new: str, message: str) -> None:
    """Each misfit alone."""
    book_of(tmp_path)
    bare = re.sub(r"```duet\n.*?```\n", "", SMALL, flags=re.DOTALL)
    assert old in bare
    (tmp_path / "01-small.de.md").write_text(bare.replace(old, new, 1), encoding="utf-8")
    book = load_lessons(tmp_path, "de")
    assert book.lessons[0].language == "en"
    assert len(book.problems) == 1 and book.problems[0].file == "01-small.de.md" and message in book.problems[0].message


def test_a_translation_carries_every_text(tmp_path: Path) -> None:
    """Titles, goals, question, answers, replies, hints and challenge; the run stays what it was."""
    book = book_of(tmp_path)
    bare = re.sub(r"```duet\n.*?```\n", "", SMALL, flags=re.DOTALL)
    words = r"(?<![{:\w#])\b(small|something|First|see|near|Near|Far|No|Yes|Run|Because|Raise|One|Two|Three|Second|Move)\b"
    (tmp_path / "01-small.de.md").write_text(re.sub(words, lambda m: f"ü{m[0]}", bare), encoding="utf-8")
    german = load_lessons(tmp_path, "de")
    assert not german.problems
    lesson, original = german.lessons[0], book.lessons[0]
    step, question, challenge = lesson.steps[0], lesson.steps[0].question, lesson.steps[0].challenge
    assert question and challenge
    texts = [lesson.title, lesson.goal, step.title, step.goal, step.do, step.explain, question.text, challenge.text, *step.hints]
    texts += [choice.text for choice in question.choices] + [choice.reply for choice in question.choices]
    assert all("ü" in text for text in texts)
    assert step.setup == original.steps[0].setup and step.trials == original.steps[0].trials


# ---- whatever it is -----------------------------------------------------------------------------------------------------------

LINES: list[str] = list[str](SMALL.splitlines(keepends=True))


@st.composite
def broken(draw: st.DrawFn) -> str:
    """The small lesson with a few lines lost, doubled, swapped or spoilt."""
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
                extra = (
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
                lines.insert(at, draw(st.sampled_from(extra)))
            case _:
                del lines[max(at, 1) :]
        if not lines:
            return ""
    return "".join(lines)


def load_text(folder: Path, text: str) -> tuple[Lesson | None, int]:
    """Load one text; return the lesson, or the line of the problem."""
    (folder / "01-small.md").write_bytes(text.encode("utf-8", "surrogatepass"))
    book = load_lessons(folder)
    assert len(book.lessons) + len(book.problems) == 1
    return (book.lessons[0], 0) if book.lessons else (None, book.problems[0].line)


@given(text=broken())
@settings(max_examples=400)
def test_a_broken_file_never_raises_and_is_named_with_a_line_of_its_own(
    tmp_path_factory: pytest.TempPathFactory, text: str
) -> None:
    """Either it still is a lesson, or the problem has a line that the file has."""
    lesson, line = load_text(tmp_path_factory.getbasetemp(), text)
    if lesson is None:
        assert 1 <= line <= max(text.count("\n") + text.count("\r") + 2, 1)
    else:
        assert lesson.steps


@given(text=st.text(max_size=200))
def test_any_text_at_all_never_raises(tmp_path_factory: pytest.TempPathFactory, text: str) -> None:
    """Not even text that is no Markdown."""
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
    """A value as TOML."""
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
    """A block with one key of any kind of value; nothing raises, and the line is that of the key or of something that it lacks."""
    text = SMALL[SMALL.index("## Second") :].replace('id = "second"\ninput = "yours"\nseconds = 1.0', f"{key} = {toml(value)}")
    text = text.replace(
        '\n[[measure]]\nname = "smallest_distance"\n', "" if key == "measure" else '\n[[measure]]\nname = "gain_step"\n'
    )
    lesson, line = load_text(tmp_path_factory.getbasetemp(), "# T\n\nG\n\n" + text)
    assert lesson is not None or 1 <= line <= 20


# ---- the command --------------------------------------------------------------------------------------------------------------


def test_the_list_names_the_lessons_and_what_was_left_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without --check nothing runs."""
    assert lessons(Lessons()) == 0
    printed = capsys.readouterr().out
    assert all(lesson.title in printed for lesson in our_book().lessons)
    book_of(tmp_path, SMALL.replace("right = 2", "right = 9"))
    book_of(tmp_path, name="02-good.md")
    assert lessons(Lessons(folder=tmp_path)) == 1
    assert "left out: 01-small.md, line" in capsys.readouterr().out


def test_bad_commands_are_named(tmp_path: Path) -> None:
    """An unknown lesson, and a file that cannot be written."""
    with pytest.raises(BadSetting, match="choose from redundancy"):
        lessons(Lessons(only=("x",)))
    with pytest.raises(BadSetting, match="there is no folder"):
        lessons(Lessons(check=True, only=("lambda",), out=tmp_path / "none" / "x.json"))


def test_positive_control_the_check_notices_what_goes_otherwise(tmp_path: Path) -> None:
    """A right answer that the run speaks against, an attempt that passes though declared to fail, and too few wrong paths."""
    text = SMALL.replace("right = 2", "right = 1").replace("choice = 1", "choice = 2").replace("at_least = 5.0", "at_least = 1.0")
    book = book_of(tmp_path, text)
    walks = {(walk.kind, walk.name): walk for walk in check_lesson(book, book.lessons[0])}
    assert "does not speak for the right answer" in walks["reference", "the right answers"].text
    assert "speaks for the wrong answer" in walks["answer", "answer 2"].text
    assert "fails by nothing instead of ('n',)" in walks["attempt", "less"].text
    assert not walks["lesson", "wrong paths"].ok
    assert not any(walks[key].ok for key in (("reference", "the right answers"), ("answer", "answer 2"), ("attempt", "less")))


# ---- notes, pictures, words ---------------------------------------------------------------------------------------------------


def test_every_lesson_has_notes_that_no_lesson_contains() -> None:
    """Only `load_notes` has them; nothing of them is in what a student's page is made from."""
    notes = load_notes()
    for lesson in our_book().lessons:
        note = notes.pop(lesson.id)
        assert "**Answers.**" in note
        everything = repr(lesson)
        assert not any(line in everything for line in note.splitlines() if len(line) > 20)
    assert not notes


def test_notes_without_a_lesson_are_a_problem_and_bad_ones_are_left_out(tmp_path: Path) -> None:
    """As with a translation."""
    book_of(tmp_path)
    (tmp_path / "01-small.notes.md").write_bytes(b"\xff\xfe")
    (tmp_path / "02-other.notes.md").write_text("x", encoding="utf-8")
    assert [problem.file for problem in load_lessons(tmp_path).problems] == ["02-other.notes.md"]
    assert load_notes(tmp_path) == {"other": "x"}
    assert load_notes(tmp_path / "none") == {}


@pytest.mark.parametrize(
    ("picture", "message"),
    [
        ("![](a.svg)", "says nothing"),
        ("![x](b.svg)", "there is no picture"),
        ("![x](../a.svg)", "no picture beside the lesson"),
        ("![x](https://example.org/a.svg)", "there is no picture"),
        ("![x](01-small.md)", "must be an .svg or .png"),
        ("![x](large.svg)", "larger than"),
        ("![x](a.svg)", ""),
    ],
)
def test_pictures_are_beside_the_lesson_and_described(tmp_path: Path, picture: str, message: str) -> None:
    """What a student's page is asked to show is there, small, and can be told to those who do not see it."""
    (tmp_path / "a.svg").write_text("<svg/>", encoding="utf-8")
    (tmp_path / "large.svg").write_text("x" * 400_000, encoding="utf-8")
    book = book_of(tmp_path, SMALL.replace("Because $x$.", f"Because {picture}."))
    assert (message in book.problems[0].message) if message else not book.problems


def test_our_pictures_are_svg_with_a_title() -> None:
    """Each is used, can be read, and says what it is."""
    texts = "".join(path.read_text(encoding="utf-8") for path in FOLDER.glob("*.md"))
    pictures = sorted(FOLDER.glob("pictures/*"))
    assert len(pictures) >= 5
    for path in pictures:
        root = ElementTree.fromstring(path.read_text(encoding="utf-8"))
        assert root.tag.endswith("svg") and (root[0].text or "").strip()
        assert f"(pictures/{path.name})" in texts


def holes(text: str) -> set[str]:
    """What is filled into a sentence."""
    return set(re.findall(r"\{(\w+)\}", text))


def test_every_sentence_is_there_in_every_language() -> None:
    """With the same things to fill in; and each label with no others than the English one has."""
    for words in WORDS.values():
        assert words.keys() == WORDS["en"].keys()
        for key, sentence in words.items():
            assert holes(sentence) == holes(WORDS["en"][key])
    for labels in LABELS.values():
        for name, label in labels.items():
            assert holes(label) == holes(QUANTITIES[name].label)


def test_what_translated_lessons_measure_is_named_in_their_language() -> None:
    """Of lessons 1 to 3, but for symbols, which are the same everywhere."""
    for language in LANGUAGES[1:]:
        for lesson in our_book(language).lessons[:3]:
            for step in lesson.steps:
                measured = [*step.measurements, *step.numbers]
                if step.challenge:
                    measured += [c.measurement for c in step.challenge.criteria]
                for m in measured:
                    name = label_of(m, language)
                    assert name and "{" not in name
                    assert name != label_of(m) or m.name in ("gain_step", "first_jump_formula", "setting")


def test_the_documents_for_teachers_name_what_exists() -> None:
    """Commands and options in the plan are those of the program; the model names the closed forms."""
    plan = (FOLDER / "lecture-plan.md").read_text(encoding="utf-8")
    assert set(re.findall(r"--([a-z][a-z-]+)", plan)) <= {"lecture", "key", "profile", "sessions", "host"}
    minutes = [int(row.split("|")[2]) for row in plan.splitlines() if re.match(r"\| \d:\d\d ", row)]
    assert sum(minutes) == 90
    model = (FOLDER / "model.md").read_text(encoding="utf-8")
    assert all(word in model for word in ("Simplified", "leaves open", "Euler", "out of authority"))
