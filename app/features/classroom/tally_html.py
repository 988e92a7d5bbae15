"""Answers of a class as bars, curves and words."""

from collections import Counter
from collections.abc import Sequence

from markupsafe import Markup

from app.features.lessons.curve_drawing import drawing_svg, median_curve
from app.features.lessons.tally import Switch, Tally
from app.i18n.speaking import tr
from app.plots.curve_chart import Curve
from app.plots.drawing_axes import Drawing
from app.text.templates import macros


def cloud_html(
    drawing: Drawing | None, rounds: Sequence[tuple[int, Tally]], truth: Curve = (), asked: bool = False
) -> Markup:
    """Curves of a class, median and truth; "" without a curve, unless `asked` shows empty axes."""
    number, newest = rounds[-1]
    earlier, curves = rounds[0][1].curves if len(rounds) > 1 else (), newest.curves
    if drawing is None or not (curves or earlier or asked):
        return Markup()
    said = "" if asked else tr("{count} drawn", count=len(curves))
    if earlier:
        first = tr("pale: round {number} ({count})", number=rounds[0][0], count=len(earlier))
        said = f"{first} · {tr('strong: round {number} ({count})', number=number, count=len(curves))}"
    svg = drawing_svg(drawing, median_curve(curves), truth, curves, earlier)
    return macros("features/classroom/tally.html").cloud(svg, said)


def drawn_too(tally: Tally) -> str:
    """Numbers of students who chose and who drew; "" without a drawing."""
    return (
        f" ({tr('{chosen} chose, {drawn} drew', chosen=tally.answered, drawn=len(tally.curves))})"
        if tally.curves
        else ""
    )


def tie_text(tally: Tally) -> str:
    """Names of the tied answers; "" without a tie."""
    if len(tally.favourites) < 2:
        return ""
    *others, last = (str(i + 1) for i in tally.favourites)
    answers = tr("{one} and {other}", one=", ".join(others), other=last)
    return tr("A tie: answers {answers}, votes for each: {count}.", answers=answers, count=max(tally.counts))


def switches_text(switches: Sequence[Switch], right: int | None) -> str:
    """Changed answers; "" if no student answered twice."""
    both = sum(one.students for one in switches)
    moved = [one for one in switches if one.before != one.after]
    if not both:
        return ""
    changed = sum(one.students for one in moved)
    text = tr(
        "Answered both times: {both}, another answer the second time: {changed}.", both=both, changed=changed
    )
    to = Counter[int]()
    for one in moved:
        to[one.after] += one.students
    for number, count in sorted(to.items()):
        text += " " + tr("To answer {number}: {count}.", number=number + 1, count=count)
    if right is None or not moved:
        return text
    gained = sum(one.students for one in moved if one.after == right)
    lost = sum(one.students for one in moved if one.before == right)
    return f"{text} {tr('From wrong to right: {gained}; from right to wrong: {lost}.', gained=gained, lost=lost)}"
