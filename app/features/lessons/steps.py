"""A step of a lesson file → `Step`, checked; readers raise `Fault`."""

import re
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Final, cast, get_args

from app.features.lessons.blocks import NEEDED, Table, is_number, quoted_value, read_block
from app.features.lessons.challenges import (
    no_doubles,
    read_challenge,
    read_identity,
    read_measurement,
    read_trials,
)
from app.features.lessons.curve_drawing import read_drawing
from app.features.lessons.lesson import (
    MOST_CHOICES,
    Challenge,
    Choice,
    Expectation,
    LessonCamera,
    Measurement,
    Question,
    Step,
)
from app.features.lessons.markdown import HEAD_SECTIONS, ITEM, Chapter, Fault, FaultLog, Sheet, read_items
from app.features.lessons.runs import Setup
from app.features.lessons.setups import read_changes, read_setup, usual_setup
from app.features.lessons.texts import placeholder_problems
from app.features.measures.quantities.quantity import QUANTITIES
from app.plots.plot_choice import possible_plots
from app.text.lesson_text import left_dollar
from app.text.picture import picture_problems
from scenes.settings import RunSettings, specs

LEFT_DOLLAR: Final = "a $ belongs to no formula; write $…$ within one paragraph, and \\$ for the sign itself."
WITH_A_RUN: Final = ("challenge", "attempt", "drawing", "why", "plots", "numbers", "marks", "camera")

MOST_PLOTS: Final = 3
MOST_NUMBERS: Final = 3
MOST_CONTROLS: Final = 3
HINTS: Final = 3
MOST_MINUTES: Final = 90
USUAL_MINUTES: Final = 10


def read_lesson(sheet: Sheet, folder: Path) -> tuple[Setup, str, int]:
    """Base run of the steps, equations of the paper, minutes."""
    log = FaultLog()
    if not sheet.head.text:
        log.found.append(Fault(sheet.head.line, "the lesson has no goal; write it under the title."))
    log.found += head_faults(sheet.head, folder)
    if len(sheet.head.blocks) > 1:
        log.found.append(
            Fault(sheet.head.blocks[1].line, "there is a second block under the title; put both into one.")
        )
    setup, equations, minutes = usual_setup(folder), "", USUAL_MINUTES
    if sheet.head.blocks and (table := log.take(lambda: read_block(sheet.head.blocks[0]), None)) is not None:
        setup = setup.with_changes(log.take(lambda: read_changes(table), ()))
        minutes = log.take(lambda: table.whole("minutes", USUAL_MINUTES, 1, MOST_MINUTES), USUAL_MINUTES)
        equations = log.take(lambda: table.text("equations", ""), "")
        log.take(table.close, None)
    log.close()
    return setup, equations, minutes


def head_faults(head: Chapter, folder: Path) -> Iterator[Fault]:
    """Faults under a lesson's title: pictures (only text is shown) and unclosed formulas."""
    for part in (head, *head.sections.values()):
        for number, line in enumerate((part.title, *part.lines), part.line):
            yield from (Fault(number, problem) for problem in picture_problems(line, folder, False))
    yield from formula_faults(head)


def formula_faults(chapter: Chapter) -> Iterator[Fault]:
    for part in (chapter, *chapter.sections.values()):
        line = left_dollar("\n".join((part.title, *part.lines)))
        if line is not None:
            yield Fault(part.line + line, LEFT_DOLLAR)


def head_texts(head: Chapter) -> tuple[str, ...]:
    return tuple(head.sections[name].text if name in head.sections else "" for name in HEAD_SECTIONS)


def step_id(title: str) -> str:
    return re.sub(r"[^a-z0-9]+", "_", title.lower()).strip("_")[:40].lstrip("0123456789_") or "step"


def read_step(part: Chapter, base: Setup) -> Step:
    """Read a step.

    `base`: the lesson's run.

    Raises:
        Fault: all faults at once.
    """
    if len(part.blocks) != 1:
        line = part.blocks[1].line if part.blocks else part.line
        raise Fault(line, f"the step has {len(part.blocks)} blocks; give it one that begins with ```duet.")
    table, log = read_block(part.blocks[0]), FaultLog()
    id = log.take(lambda: read_identity(table, step_id(part.title)), "")
    concept = log.take(lambda: table.flag("concept"), False)
    if concept:
        log.found += [
            table.fault(key, f"a question without a run has no {key}.")
            for key in WITH_A_RUN
            if table.has(key)
        ]
    setup = log.take(lambda: read_setup(table, base), None)
    if setup is None:
        # The rest depends on the run.
        log.close()
    assert setup is not None
    noted = len(log.found)
    entries = log.take(lambda: table.tables("measure"), [])
    measurements = log.all_of([partial(read_measurement, entry, setup) for entry in entries])
    log.take(lambda: no_doubles(table, "measure", [m.id for m in measurements]), None)
    measured = len(log.found) == noted
    question = log.take(
        lambda: _question(part, table, setup, measurements if measured else None, concept), None
    )
    challenged = table.has("challenge")
    challenge = log.take(lambda: read_challenge(table, setup), None)
    texts: dict[str, Any] = _checked_texts(part, "Predict" in part.sections, challenged, concept, log)
    challenge_text = texts.pop("challenge")
    hints = log.take(lambda: _hints(part, challenge), ())
    sound = measured and challenged is (challenge is not None)
    trials = log.take(lambda: read_trials(table, challenge, measurements), ()) if sound else ()
    live = [name for name, found in QUANTITIES.items() if found.live and not found.parameters]
    numbers = tuple(
        Measurement(name, name, (), QUANTITIES[name].shown, QUANTITIES[name].digits)
        for name in log.take(lambda: table.words("numbers", live, MOST_NUMBERS), ())
    )
    marks = log.take(lambda: table.numbers("marks"), ())
    if marks and setup.run.experiment.obstacle != "nothing":
        log.found.append(table.fault("marks", "marks for the elbow need the scene solo."))
    drawing = log.take(lambda: read_drawing(table, setup), None)
    if drawing is not None and "Predict" not in part.sections:
        log.found.append(
            table.fault(
                "drawing", "a drawing comes before the answers to a question; add a section “### Predict”."
            )
        )
    camera = log.take(lambda: table.choice("camera", get_args(LessonCamera), "room"), "room")
    plots = log.take(lambda: table.words("plots", possible_plots(setup.run), MOST_PLOTS), ())
    offered = [key for key, spec in specs(RunSettings).items() if spec.read is None]
    controls = log.take(lambda: table.words("controls", offered, MOST_CONTROLS), ())
    step = Step(
        id=id,
        title=part.title,
        setup=setup,
        question=question,
        measurements=measurements,
        challenge=replace(challenge, text=challenge_text) if challenge is not None else None,
        hints=hints,
        trials=trials,
        camera=cast(LessonCamera, camera),
        plots=plots,
        numbers=numbers,
        marks=marks,
        drawing=drawing,
        concept=concept,
        controls=controls,
        **texts,
    )
    for key in ("right", "expects", "ratio", "why", "attempt"):
        # Not read if something else is at fault.
        table.any(key)
    log.take(table.close, None)
    if measured:
        log.found += _line_faults(part, step)
    log.close()
    return step


def _question(
    part: Chapter, table: Table, setup: Setup, measurements: tuple[Measurement, ...] | None, concept: bool
) -> Question | None:
    """Read the question. `measurements`: None if they are faulty."""
    section = part.sections.get("Predict")
    if section is None:
        if concept:
            raise table.fault("concept", "a question without a run needs a section “### Predict”.")
        for key in ("right", "expects", "ratio", "why"):
            if table.has(key):
                raise table.fault(
                    key, f"{key} is about a question, but the step has no section “### Predict”."
                )
        return None
    text, items = read_items(section)
    if not text:
        raise Fault(section.line, "the question is missing; write it above the numbered answers.")
    if not 2 <= len(items) <= MOST_CHOICES:
        raise Fault(
            section.line,
            f"the question has {len(items)} answers; give 2 to {MOST_CHOICES}, numbered 1, 2, 3 …",
        )
    log, reply = (
        FaultLog(),
        "the answer has no reply; write what is said to it in lines below that begin with >.",
    )
    log.found += [Fault(item.line, reply) for item in items if not item.quote]
    right = log.take(lambda: table.whole("right", NEEDED, 1, len(items)), 0) - 1
    if not concept and measurements == ():
        log.found.append(Fault(section.line, "a prediction needs an outcome; add [[measure]] to the block."))
    expects, ratio = (
        log.take(lambda: _expects(table, len(items)), ()),
        log.take(lambda: table.flag("ratio"), False),
    )
    if ratio and measurements is not None and not (measurements and measurements[0].compare):
        message = "a ratio needs a run to compare with; add compare = [{ … }] to the first measurement."
        log.found.append(table.fault("ratio", message))
    log.close()
    whys: dict[int, tuple[Setup, bool, bool]] = {}
    for entry in table.tables("why"):
        number = entry.whole("choice", NEEDED, 1, len(items)) - 1
        if number == right or number in whys:
            raise entry.fault(
                "choice", "each wrong answer has at most one run of its own, the right one has none."
            )
        whys[number] = read_setup(entry, setup), entry.flag("otherwise"), entry.flag("same")
        entry.close()
    choices = tuple(
        Choice(item.text, item.quote, *whys.get(i, (None, False, False))) for i, item in enumerate(items)
    )
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
        raise table.fault(
            "expects",
            f"{quoted_value(values)} is not a range; write [low, high] with low < high, inf is possible.",
        )
    return float(values[0]), float(values[1])


def step_texts(part: Chapter, step: Step) -> dict[str, str]:
    """Texts in another language, by field of `Step`, and its challenge's."""
    log, challenge = FaultLog(), step.challenge is not None
    texts = _checked_texts(part, step.question is not None, challenge, step.concept, log)
    asked = {"Hints": bool(step.hints), "Predict": step.question is not None}
    missing = [name for name, needed in asked.items() if needed and name not in part.sections]
    log.found += [Fault(part.line, f"the step has no section “### {name}”.") for name in missing]
    log.found += _line_faults(part, step)
    log.close()
    return texts


def _checked_texts(
    part: Chapter, question: bool, challenge: bool, concept: bool, log: FaultLog
) -> dict[str, str]:
    names = ("Goal", "Do", "Observe", "Explain", "Challenge", "Belief")
    texts = {name.lower(): part.sections[name].text if name in part.sections else "" for name in names}
    needed = {
        "Goal": not concept,
        "Do": not concept,
        "Explain": question and not concept,
        "Challenge": challenge,
    }
    missing = [name for name, needs in needed.items() if needs and not texts[name.lower()]]
    log.found += [Fault(part.line, f"the step has no text under “### {name}”; add it.") for name in missing]
    if not challenge and texts["challenge"]:
        where = part.sections["Challenge"].line
        log.found.append(Fault(where, "the challenge is not declared; add [challenge] to the block."))
    return texts


def _hints(part: Chapter, challenge: Challenge | None) -> tuple[str, ...]:
    section = part.sections.get("Hints")
    if section is None:
        if challenge is not None:
            raise Fault(part.line, f"a challenge has {HINTS} hints; add “### Hints” with a numbered list.")
        return ()
    _, items = read_items(section)
    if len(items) != HINTS:
        raise Fault(
            section.line, f"there are {len(items)} hints; give {HINTS}, from a nudge to the way itself."
        )
    return tuple(item.text for item in items)


def _line_faults(part: Chapter, step: Step) -> Iterator[Fault]:
    folder = step.setup.folder
    yield from (Fault(part.line, problem) for problem in picture_problems(part.title, folder, False))
    yield from formula_faults(part)
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
            yield from (
                Fault(number, problem) for problem in (*placeholder_problems(line, step, before), *pictures)
            )
