"""The answers of a class as bars, curves and words; a question that was asked again has two bars an answer, the first round's pale."""

from collections.abc import Sequence

from app.i18n.speaking import tr
from app.lessons.curve_drawing import Drawing, drawing_svg, median_curve
from app.lessons.tally import Switch, Tally
from app.plots.curve_chart import Curve
from app.text.html_element import element
from app.text.lesson_text import inline_html


def bars_html(
    choices: Sequence[str], rounds: Sequence[tuple[int, Tally]], right: int | None = None, mine: int | None = None
) -> str:
    """Return a list with the bars of every answer.

    Args:
        choices: as Markdown.
        rounds: number and counts of each, oldest first; the last one is drawn strong.
        right: the right answer; None while it is not known.
        mine: the reader's own answer.
    """
    rows: list[str] = []
    for i, choice in enumerate(choices):
        kinds = " ".join(name for name, true in (("right", right == i), ("mine", mine == i)) if true)
        head = element("i", f"{i + 1}"), element("span", "", inline_html(choice))
        bars = _bar(rounds[0][1], i) if len(rounds) == 1 else "".join(_round(number, tally, i) for number, tally in rounds)
        rows.append(element("li", "", *head, bars, class_=kinds))
    return element("ol", "", *rows)


def _bar(tally: Tally, choice: int) -> str:
    share = tally.share(choice)
    percent = [] if share is None else [element("small", f"{share} %")]
    width = element("div", style=f"width:{share or 0}%")
    return element("b", f"{tally.counts[choice]} ", *percent) + element("div", "", width, aria_hidden="true")


def _round(number: int, tally: Tally, choice: int) -> str:
    return element("section", "", element("small", tr("Round {number}", number=number)), _bar(tally, choice), class_="round")


def cloud_html(drawing: Drawing | None, rounds: Sequence[tuple[int, Tally]], truth: Curve = ()) -> str:
    """Return the class's curves over one another, their medians, and the truth once it is known; "" without a curve."""
    number, newest = rounds[-1]
    earlier, curves = rounds[0][1].curves if len(rounds) > 1 else (), newest.curves
    if drawing is None or not (curves or earlier):
        return ""
    said = tr("{count} drawn", count=len(curves))
    if earlier:
        first = tr("pale: round {number} ({count})", number=rounds[0][0], count=len(earlier))
        said = f"{first} · {tr('strong: round {number} ({count})', number=number, count=len(curves))}"
    svg = drawing_svg(drawing, median_curve(curves), truth, curves, earlier)
    return element("figure", "", svg, element("figcaption", said), class_="duet duet-curves")


def tie_text(tally: Tally) -> str:
    """Return that the most frequent answers are as many; "" where one is ahead."""
    if len(tally.favourites) < 2:
        return ""
    *others, last = (str(i + 1) for i in tally.favourites)
    answers = tr("{one} and {other}", one=", ".join(others), other=last)
    return tr("A tie: answers {answers}, votes for each: {count}.", answers=answers, count=max(tally.counts))


def switches_text(switches: Sequence[Switch], right: int | None) -> str:
    """Return how many have changed their answer, and from and to the right one once that is known; "" if none answered twice."""
    both = sum(one.students for one in switches)
    moved = [one for one in switches if one.before != one.after]
    if not both:
        return ""
    changed = sum(one.students for one in moved)
    text = tr("Answered both times: {both}, another answer the second time: {changed}.", both=both, changed=changed)
    if right is None or not moved:
        return text
    gained = sum(one.students for one in moved if one.after == right)
    lost = sum(one.students for one in moved if one.before == right)
    return f"{text} {tr('From wrong to right: {gained}; from right to wrong: {lost}.', gained=gained, lost=lost)}"
