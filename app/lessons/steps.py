"""One step of a lesson file → `Step`: its texts, and everything that its block declares, checked."""

import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, cast, get_args

from app.lessons.blocks import NEEDED, Table, is_number, read_block, shown
from app.lessons.challenges import no_doubles, read_challenge, read_identity, read_measurement, read_trials
from app.lessons.curve_drawing import read_drawing
from app.lessons.lesson import (
    HINTS,
    MOST_NUMBERS,
    MOST_PLOTS,
    Camera,
    Challenge,
    Choice,
    Expectation,
    Measurement,
    Question,
    Step,
    possible_plots,
)
from app.lessons.markdown import HEAD_SECTIONS, ITEM, Chapter, Fault, Sheet, read_items
from app.lessons.measures.quantity import QUANTITIES
from app.lessons.runs import Pairs, Setup
from app.lessons.setups import read_changes, read_setup
from app.lessons.texts import placeholder_problems
from app.text.lesson_text import left_dollar
from app.text.picture import picture_problems

LEFT_DOLLAR: Final = "a $ belongs to no formula; write $…$ within one paragraph, and \\$ for the sign itself."
MOST_CHOICES: Final = 6
MOST_MINUTES: Final = 90


@dataclass(frozen=True)
class Common:
    """What all steps of a lesson begin with."""

    folder: Path
    changes: Pairs
    equations: str
    minutes: int


def read_lesson(sheet: Sheet, folder: Path) -> Common:
    """Return the settings of the block under the title.

    Raises:
        Fault: it is not such a block, there are several, or the lesson has no goal.
    """
    if not sheet.head.text:
        raise Fault(sheet.head.line, "the lesson has no goal; write it under the title.")
    check_head(sheet.head, folder)
    if len(sheet.head.blocks) > 1:
        raise Fault(sheet.head.blocks[1].line, "there is a second block under the title; put both into one.")
    if not sheet.head.blocks:
        return Common(folder, (), "", 10)
    table = read_block(sheet.head.blocks[0])
    common = Common(folder, read_changes(table), table.text("equations", ""), table.whole("minutes", 10, 1, MOST_MINUTES))
    table.close()
    return common


def check_head(head: Chapter, folder: Path) -> None:
    """Complain of a picture in what stands under a lesson's title, which is shown as lines of text.

    Raises:
        Fault: there is one.
    """
    for part in (head, *head.sections.values()):
        for number, line in enumerate((part.title, *part.lines), part.line):
            for problem in picture_problems(line, folder, False):
                raise Fault(number, problem)
    check_formulas(head)


def check_formulas(chapter: Chapter) -> None:
    """Complain of a formula that has no end.

    Raises:
        Fault: there is one.
    """
    for part in (chapter, *chapter.sections.values()):
        line = left_dollar("\n".join((part.title, *part.lines)))
        if line is not None:
            raise Fault(part.line + line, LEFT_DOLLAR)


def head_texts(head: Chapter) -> tuple[str, ...]:
    """Return what a lesson promises and what was learned in it, "" for what the file does not say."""
    return tuple(head.sections[name].text if name in head.sections else "" for name in HEAD_SECTIONS)


def step_id(title: str) -> str:
    """Return a title as an identity: small letters and underscores."""
    return re.sub(r"[^a-z0-9]+", "_", title.lower()).strip("_")[:40].lstrip("0123456789_") or "step"


def read_step(part: Chapter, common: Common) -> Step:
    """Return a step.

    Raises:
        Fault: something is missing or not possible.
    """
    if len(part.blocks) != 1:
        line = part.blocks[1].line if part.blocks else part.line
        raise Fault(line, f"the step has {len(part.blocks)} blocks; give it one that begins with ```duet.")
    table = read_block(part.blocks[0])
    id = read_identity(table, "id", step_id(part.title))
    setup = read_setup(table, common.folder, common.changes)
    measurements = tuple(read_measurement(entry, setup) for entry in table.tables("measure"))
    no_doubles(table, "measure", [m.id for m in measurements])
    question = _question(part, table, setup, measurements)
    challenge = read_challenge(table, setup)
    texts = _checked_texts(part, question, challenge)
    hints = _hints(part, challenge)
    trials = read_trials(table, setup, challenge, measurements)
    live = [name for name, found in QUANTITIES.items() if found.live and not found.parameters]
    numbers = tuple(
        Measurement(name, name, (), QUANTITIES[name].shown, QUANTITIES[name].digits)
        for name in table.words("numbers", live, MOST_NUMBERS)
    )
    marks = table.numbers("marks")
    if marks and setup.run.experiment.obstacle != "nothing":
        raise table.fault("marks", "marks for the elbow need the scene solo.")
    drawing = read_drawing(table, setup)
    if drawing is not None and question is None:
        raise table.fault("drawing", "a drawing comes before the answers to a question; add a section “### Predict”.")
    step = Step(
        id,
        part.title,
        texts["Goal"],
        texts["Do"],
        texts["Observe"],
        texts["Explain"],
        setup,
        question,
        measurements,
        replace(challenge, text=texts["Challenge"]) if challenge is not None else None,
        hints,
        trials,
        cast(Camera, table.choice("camera", get_args(Camera), "room")),
        table.words("plots", possible_plots(setup.run), MOST_PLOTS),
        numbers,
        marks,
        drawing,
    )
    table.close()
    _check_lines(part, step)
    return step


def _question(part: Chapter, table: Table, setup: Setup, measurements: tuple[Measurement, ...]) -> Question | None:
    section = part.sections.get("Predict")
    if section is None:
        for key in ("right", "expects", "ratio", "why"):
            if table.has(key):
                raise table.fault(key, f"{key} is about a question, but the step has no section “### Predict”.")
        return None
    text, items = read_items(section)
    if not text:
        raise Fault(section.line, "the question is missing; write it above the numbered answers.")
    if not 2 <= len(items) <= MOST_CHOICES:
        raise Fault(section.line, f"the question has {len(items)} answers; give 2 to {MOST_CHOICES}, numbered 1, 2, 3 …")
    for item in items:
        if not item.quote:
            raise Fault(item.line, "the answer has no reply; write what is said to it in lines below that begin with >.")
    right = table.whole("right", NEEDED, 1, len(items)) - 1
    if not measurements:
        raise Fault(section.line, "a prediction needs an outcome; add [[measure]] to the block.")
    expects, ratio = _expects(table, len(items)), table.flag("ratio")
    if ratio and not measurements[0].compare:
        raise table.fault("ratio", "a ratio needs a run to compare with; add compare = [{ … }] to the first measurement.")
    whys: dict[int, tuple[Setup, bool]] = {}
    for entry in table.tables("why"):
        number = entry.whole("choice", NEEDED, 1, len(items)) - 1
        if number == right or number in whys:
            raise entry.fault("choice", "each wrong answer has at most one run of its own, the right one has none.")
        whys[number] = read_setup(entry, setup.folder, setup.changes, setup), entry.flag("otherwise")
        entry.close()
    choices = tuple(Choice(item.text, item.quote, *whys.get(i, (None, False))) for i, item in enumerate(items))
    return Question(text, choices, right, expects, ratio)


def _expects(table: Table, count: int) -> tuple[Expectation, ...]:
    values = table.any("expects", [])
    if not values:
        return ()
    message = "expects must hold a number for each answer, or a range [low, high] for each"
    if not isinstance(values, list) or len(values) != count:
        raise table.fault("expects", f"{message}; the step has {count} answers.")
    if all(isinstance(x, list) and len(x) == 2 for x in values):
        return tuple(_range(table, x) for x in values)
    if not all(is_number(x) for x in values):
        raise table.fault("expects", f"{message}, all of one kind.")
    return tuple(float(x) for x in values)


def _range(table: Table, values: list[Any]) -> tuple[float, float]:
    if not all(is_number(x) for x in values) or not values[0] < values[1]:
        raise table.fault("expects", f"{shown(values)} is not a range; write [low, high] with low < high, inf is possible.")
    return float(values[0]), float(values[1])


def step_texts(part: Chapter, step: Step) -> dict[str, str]:
    """Return the texts of a step in another language, checked to be complete.

    Raises:
        Fault: a section is missing.
    """
    texts = _checked_texts(part, step.question, step.challenge)
    if step.hints and "Hints" not in part.sections:
        raise Fault(part.line, "the step has no section “### Hints”.")
    if step.question is not None and "Predict" not in part.sections:
        raise Fault(part.line, "the step has no section “### Predict”.")
    _check_lines(part, step)
    return texts


def _checked_texts(part: Chapter, question: Question | None, challenge: Challenge | None) -> dict[str, str]:
    names = ("Goal", "Do", "Observe", "Explain", "Challenge")
    texts = {name: part.sections[name].text if name in part.sections else "" for name in names}
    needed = ["Goal", "Do", *(["Explain"] if question is not None else []), *(["Challenge"] if challenge is not None else [])]
    for name in needed:
        if not texts[name]:
            raise Fault(part.line, f"the step has no text under “### {name}”; add it.")
    if challenge is None and texts["Challenge"]:
        raise Fault(part.sections["Challenge"].line, "the challenge is not declared; add [challenge] to the block.")
    return texts


def _hints(part: Chapter, challenge: Challenge | None) -> tuple[str, ...]:
    section = part.sections.get("Hints")
    if section is None:
        if challenge is not None:
            raise Fault(part.line, f"a challenge has {HINTS} hints; add “### Hints” with a numbered list.")
        return ()
    _, items = read_items(section)
    if len(items) != HINTS:
        raise Fault(section.line, f"there are {len(items)} hints; give {HINTS}, from a nudge to the way itself.")
    return tuple(item.text for item in items)


def _check_lines(part: Chapter, step: Step) -> None:
    folder = step.setup.folder
    for problem in picture_problems(part.title, folder, False):
        raise Fault(part.line, problem)
    check_formulas(part)
    for section in part.sections.values():
        # Answers are buttons, and hints are a list.
        listed = section.title == "Hints"
        for number, line in enumerate(section.lines, section.line + 1):
            # A reply, quoted under its answer, is read after the run.
            reply = section.title == "Predict" and line.lstrip().startswith(">")
            listed = listed or (section.title == "Predict" and ITEM.match(line) is not None)
            before = section.title in ("Goal", "Predict", "Do") and not reply
            text = line.lstrip(" \t>") if reply else line
            pictures = picture_problems(text, folder, reply or not listed)
            for problem in (*placeholder_problems(line, step, before), *pictures):
                raise Fault(number, problem)
