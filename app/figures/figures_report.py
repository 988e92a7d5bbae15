"""The report: every figure, what the paper says of it, and what these very runs came to."""

from collections.abc import Sequence
from typing import NamedTuple

from app.figures.figure_list import FigureEntry
from app.figures.run_plan import Plan


class Section(NamedTuple):
    """What the report says of one figure: the figure, and the sentences found."""

    entry: FigureEntry
    found: Sequence[str]


def report(sections: Sequence[Section], plan: Plan, version: str) -> str:
    """Return the report as Markdown, for the folder in which the figures are."""
    lines = [
        "# The paper's figures, drawn from our own runs",
        "",
        "T. Petrič and L. Žlajpah, *Smooth Transition Between Tasks on a Kinematic Control Level: Application to Self Collision "
        "Avoidance for Two Kuka LWR Robots*, IEEE ROBIO 2011.",
        "",
        f"Made by `lwr-duet figures --seed {plan.seed}{' --quick' if plan.quick else ''}`, version {version}. Every number below comes "
        "from the runs of this call; the settings are on top of every CSV file, and the same call writes the same bytes of CSV. "
        "v, n, K and the time step are not in the paper: they are ours, as is the person who moves the arms.",
        "",
        "The text of the paper that we had has lost its zeros and ones: d_m = 0.15 m in Fig. 5 is read from damaged text (0.05 m would "
        "fit too), and so is the axis of e², read as 0 to 0.2 m².",
        "",
    ]
    if plan.quick:
        lines += ["**Quick**: shorter runs and fewer points than the figures are meant to have.", ""]
    for entry, found in sections:
        stem = entry.stem
        lines += [f"## {entry.heading}", "", f"![{entry.heading}]({stem}.png)", "", f"**The paper.** {entry.paper}", ""]
        lines += ["**What we found.**", ""]
        for sentence in found:
            # A table stands by itself.
            lines += [sentence, ""] if sentence.startswith("|") else [f"- {sentence}"]
        if lines[-1]:
            lines.append("")
        lines += [f"[{stem}.csv]({stem}.csv) · [{stem}.png]({stem}.png) · [{stem}.svg]({stem}.svg)", ""]
    return "\n".join(lines)
