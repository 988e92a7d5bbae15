"""Measurements of a run and of those that it is compared with, as a table in Markdown."""

from collections.abc import Sequence

from app.i18n.catalogue import words_of
from app.i18n.speaking import N_
from app.lessons.labels import compared_text, label_of
from app.lessons.lesson import Measurement
from app.lessons.measures.quantity import Value, shown_parameter
from app.lessons.runs import Setup, page_value
from app.settings import Language, Settings
from scenes.settings import specs, values


def series_table(shown: Sequence[Measurement], found: Sequence[tuple[Value, ...]], setup: Setup, language: Language) -> str:
    """Return a table with a row for each run, in the order of the one number in which they differ, if it is one.

    Args:
        shown: measurements with the same comparisons; at least one.
        found: of each its value, then those of its comparisons.
        setup: of the run itself.
    """
    head, runs = _runs(shown[0], setup, language)
    columns = [head, *(label_of(m, language) for m in shown)]
    rows = [
        (place, [name, *(m.text(row[i]) if i < len(row) else "–" for m, row in zip(shown, found, strict=True))])
        for i, (place, name) in enumerate(runs)
    ]
    rows.sort(key=lambda row: row[0])
    lines = [columns, ["---", *("---:" for _ in shown)], *(cells for _, cells in rows)]
    return "\n\n" + "\n".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |" for cells in lines) + "\n\n"


def _runs(m: Measurement, setup: Setup, language: Language) -> tuple[str, list[tuple[float, str]]]:
    """Return what the runs differ in, and of each its place in the table and its name; the run itself is the first."""
    words = words_of(language)
    keys = {key for compared in m.compare for key, _ in compared.changes}
    others = [compared.setup(setup) for compared in m.compare]
    (key,) = keys if len(keys) == 1 else ("",)
    if key and isinstance(values(setup.run)[key], float) and all(compared.start is None for compared in m.compare):
        numbers = [float(values(run.run)[key]) for run in (setup, *others)]
        return words(specs(Settings)[key].label), [(number, page_value(key, number, language)) for number in numbers]
    balls = [run.start.ball if run.start is not None else None for run in (setup, *others)]
    tilts = [ball.tilt for ball in balls if ball is not None]
    if not keys and len(tilts) == len(balls) == len(set(tilts)):
        return words(N_("angle")), [(tilt, shown_parameter("angle", tilt)) for tilt in tilts]
    names = [words(N_("this run")), *(compared_text(compared, language) for compared in m.compare)]
    return words(N_("run")), [(float(i), name) for i, name in enumerate(names)]
