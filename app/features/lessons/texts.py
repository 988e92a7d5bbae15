"""Numbers in lesson texts: `{measured:drift}`, `{measured:drift:1}` (first comparison),
`{measured:drift:ratio}`, `{measured:margin:side}` ("3 mm below"), `{measured:margin:size}` (unsigned),
`{setting:dm}`, and on its own line `{table:drift}`.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from app.features.lessons.labels import compared_text, label_of
from app.features.lessons.lesson import Measurement, Step
from app.features.lessons.outcomes import StepOutcome, reference
from app.features.lessons.runs import Setup
from app.features.measures.quantities.quantity import Value, shown_parameter
from app.i18n.catalogue import words_of
from app.i18n.speaking import N_
from app.settings import Language, Settings
from app.text.setting_values import page_value
from controllers.errors import NumberText
from scenes.laws import LEVER_LAW
from scenes.setting_spec import unknown_setting
from scenes.settings import specs, values


def series_table(
    shown: Sequence[Measurement], found: Sequence[tuple[Value, ...]], setup: Setup, language: Language
) -> str:
    """Table with a row for each run, sorted by the number in which the runs differ.

    Args:
        shown: with the same comparisons.
        found: value of each, then of its comparisons.
    """
    head, runs = _runs(shown[0], setup, language)
    columns = [head, *(label_of(m, language) for m in shown)]
    rows = [
        [
            runs[i][1],
            *(
                words_of(language)(m.text(row[i])) if i < len(row) else "–"
                for m, row in zip(shown, found, strict=True)
            ),
        ]
        for i in sorted(range(len(runs)), key=lambda i: runs[i][0])
    ]
    lines = [columns, ["---", *("---:" for _ in shown)], *rows]
    return (
        "\n\n"
        + "\n".join(
            f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |" for cells in lines
        )
        + "\n\n"
    )


def _runs(m: Measurement, setup: Setup, language: Language) -> tuple[str, list[tuple[float, str]]]:
    """Difference of the runs; sort value and name of each, the run itself first."""
    words = words_of(language)
    keys = {key for compared in m.compare for key, _ in compared.changes}
    others = [compared.setup(setup) for compared in m.compare]
    (key,) = keys if len(keys) == 1 else ("",)
    if (
        key
        and isinstance(values(setup.run)[key], float)
        and all(compared.start is None for compared in m.compare)
    ):
        numbers = [float(values(run.run)[key]) for run in (setup, *others)]
        return words(specs(Settings)[key].label), [
            (number, page_value(key, number, language)) for number in numbers
        ]
    balls = [run.start.ball if run.start is not None else None for run in (setup, *others)]
    tilts = [ball.tilt for ball in balls if ball is not None]
    if not keys and len(tilts) == len(balls) == len(set(tilts)):
        return words(N_("angle")), [(tilt, words(shown_parameter("angle", tilt))) for tilt in tilts]
    if keys == {"law"} and setup.run.law.law == LEVER_LAW:
        # As in the plots' legends.
        names = [words(N_("you")), *(page_value("law", other.run.law.law, language) for other in others)]
    else:
        kept = setup.run.quantity
        names = [words(N_("this run")), *(compared_text(compared, language, kept) for compared in m.compare)]
    return words(N_("run")), [(float(i), name) for i, name in enumerate(names)]


_HOLE: Final = re.compile(r"\{(measured|setting|table):([^{}]*)\}")


def _parts(name: str) -> tuple[str, str, str]:
    """Id; index of the comparison or "ratio"; "side", "size" or ""."""
    whole, _, form = name.rpartition(":")
    if form not in ("side", "size"):
        whole, form = name, ""
    id, _, number = whole.partition(":")
    return id, number, form


def tabled(text: str) -> frozenset[str]:
    """Ids of the measurements in a text's tables."""
    return frozenset(id for kind, name in _HOLE.findall(text) if kind == "table" for id in name.split(","))


def told_in(step: Step, text: str) -> frozenset[str]:
    """Ids of the measurements of which a text shows every value."""
    told = {
        (id, number)
        for kind, name in _HOLE.findall(text)
        if kind == "measured"
        for id, number, _ in [_parts(name)]
    }
    wanted = ((m.id, ("", *(str(i + 1) for i in range(len(m.compare))))) for m in step.measurements)
    return frozenset(id for id, numbers in wanted if all((id, number) in told for number in numbers))


def placeholder_problems(line: str, step: Step, before: bool = False) -> Iterator[str]:
    """Yield faults in the placeholders of a line.

    `before`: the line is seen before the run, so the outcome must be hidden.
    """
    by_id = {m.id: m for m in step.measurements}
    for kind, name in _HOLE.findall(line):
        if kind == "setting":
            if name not in specs(Settings):
                yield f"{{setting:{name}}}: {unknown_setting(name, specs(Settings))}"
            continue
        if kind == "table":
            yield from _table_problems(name, line, by_id, before)
            continue
        id, number, _ = _parts(name)
        if id not in by_id:
            yield f"{{measured:{name}}}: the step measures no {id!r}; choose from {', '.join(by_id) or 'none: add [[measure]]'}."
        elif (
            before and step.question is not None and id == step.measurements[0].id and number in ("", "ratio")
        ):
            yield f"{{measured:{name}}} gives the answer away before the run; name a comparison, such as {{measured:{id}:1}}."
        elif number == "ratio" and by_id[id].compare:
            continue
        elif number and not (number.isdecimal() and 1 <= int(number) <= len(by_id[id].compare)):
            yield f"{{measured:{name}}}: {id} has {len(by_id[id].compare)} comparisons; number them from 1."


BLANK: Final = "\\_" * 10
"""For a number to be written by hand."""


def without_outcome(text: str, step: Step) -> str:
    """Replace numbers that give the answer away."""

    def kept(hole: re.Match[str]) -> str:
        known = hole[1] == "setting" or step.question is not None
        return hole[0] if known and not any(placeholder_problems(hole[0], step, True)) else BLANK

    return _HOLE.sub(kept, text)


def _table_problems(name: str, line: str, by_id: Mapping[str, Measurement], before: bool) -> Iterator[str]:
    found = [by_id[id] for id in name.split(",") if id in by_id]
    if len(found) < len(name.split(",")):
        yield f"{{table:{name}}}: a table is of measurements of the step; choose from {', '.join(by_id) or 'none: add [[measure]]'}."
    elif not found[0].compare or any(m.compare != found[0].compare for m in found):
        yield f"{{table:{name}}}: a table needs further runs to compare with, the same for all its measurements."
    elif line.strip(" \t>") != f"{{table:{name}}}":
        yield f"{{table:{name}}} stands on a line of its own."
    elif before:
        yield f"{{table:{name}}} gives the answer away before the run; put it under Observe or Explain."


def fill(step: Step, text: str, outcome: StepOutcome | None, language: Language) -> str:
    """Fill in a text's numbers, "–" if unknown; without an outcome, those of the reference run."""
    if outcome is None and any(kind != "setting" for kind, _ in _HOLE.findall(text)):
        outcome = reference(step, step.setup)
    by_id, words, setup = {m.id: m for m in step.measurements}, words_of(language), step.setup
    measured = outcome.known(step) if outcome is not None else {}

    def shown(hole: re.Match[str]) -> str:
        kind, name = hole[1], hole[2]
        if kind == "setting":
            found = values(setup.settings(Settings()))
            return page_value(name, found[name], language) if name in found else "–"
        if kind == "table":
            listed = [by_id[id] for id in name.split(",") if id in by_id]
            return series_table(listed, [measured.get(m.id, ()) for m in listed], setup, language)
        id, number, form = _parts(name)
        known = measured.get(id, ())
        if number == "ratio":
            own, other = (*known, None, None)[:2]
            return words(NumberText(f"{own / other:.2f}")) if own is not None and other else "–"
        index = int(number) if number else 0
        value = known[index] if index < len(known) else None
        if form == "size" and value is not None:
            value = abs(value)
        if form == "side" and value is not None:
            return words(
                N_("{size} below") if value < 0.0 else N_("{size} above"), size=by_id[id].text(abs(value))
            )
        return words(by_id[id].text(value)) if id in by_id else "–"

    return _HOLE.sub(shown, text)
