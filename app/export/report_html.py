"""A lab report as one HTML page that prints well: predictions beside outcomes, plots, settings, and a student's own words."""

import html
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from app.export.report_record import StepRecord, records_html
from app.i18n.speaking import spoken, tr
from app.lessons.runs import page_value
from app.recording.provenance import made_here
from app.session.relevant_settings import matters
from app.settings import Settings
from app.theme import PALETTES
from scenes.settings import RunSettings, specs, values

LOCKED: Final = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
"""The page may load nothing and run nothing."""


@dataclass(frozen=True)
class ReportEntry:
    """One step of a lesson. What is empty is left out.

    Attributes:
        prediction: the answer that was chosen, before anything was seen.
        right: whether it was the right one; None if nothing is known yet, or nothing was asked.
        verdict: what was said to it.
        outcome: lines with what was measured.
        judgements: of the challenge's newest attempt: line, and whether it was met.
        attempts: how often the challenge was tried.
        passed: whether it was ever passed; None if there is none.
        words: what the student wrote.
        chapter: under which it stands, such as the lesson's title; a heading where it is another one than before.
        settings: of the run, as a person reads them.
        drawing: the student's curve beside the measured one, an <svg> element.
        drawing_verdict: how near it came.
        plot: picture of the run, an <svg> element as `app.export.plot_pictures.inline_svg` makes it.
        because: the student's reason for the prediction.
        record: the same for a program, see `records_html`.
    """

    title: str
    question: str = ""
    prediction: str = ""
    right: bool | None = None
    verdict: str = ""
    outcome: Sequence[str] = ()
    judgements: Sequence[tuple[str, bool]] = ()
    attempts: int = 0
    passed: bool | None = None
    words: str = ""
    chapter: str = ""
    settings: str = ""
    plot: str = ""
    drawing: str = ""
    drawing_verdict: str = ""
    because: str = ""
    record: StepRecord | None = None


def report_html(
    title: str,
    entries: Sequence[ReportEntry],
    settings: Settings | None,
    *,
    about: str = "",
    rich: Callable[[str], str] = html.escape,
) -> str:
    """Return the page. Nothing in it loads anything or runs, and everything that a person wrote is escaped.

    Args:
        entries: the steps, in order.
        settings: of the last run; None to leave them out.
        about: one line under the title, such as a name and a date.
        rich: makes HTML of a text of the lesson's author (question, prediction, verdict, outcome, judgement), for formulas; the
            title, `about` and all words of the student are escaped whatever it is.

    Raises:
        ValueError: a plot is no plain <svg> element.
    """
    parts = [f"<h1>{html.escape(title)}</h1>"]
    made = f"{tr('Made by Duet')} {made_here()['duet']}"
    parts.append(f'<p class="about">{html.escape(f"{about} · {made}" if about else made)}</p>')
    for before, entry in zip(("", *(entry.chapter for entry in entries)), entries, strict=False):
        if entry.chapter not in ("", before):
            parts.append(f'<h2 class="chapter">{html.escape(entry.chapter)}</h2>')
        parts.append(entry_html(entry, rich))
    if settings is not None:
        parts.append(f"<h2>{html.escape(tr('Settings of the last run'))}</h2>{_table(settings)}")
    parts.append(records_html([entry.record for entry in entries if entry.record is not None]))
    return locked_page(title, ("report.css",), parts)


def locked_page(title: str, styles: Sequence[str], parts: Sequence[str]) -> str:
    """Return an HTML page that loads and runs nothing, in the reader's language.

    Args:
        styles: names of style sheets in this folder.
        parts: of the body, as HTML.
    """
    sheet = "".join(Path(__file__).with_name(name).read_text(encoding="utf-8") for name in styles)
    return (
        f'<!doctype html>\n<html lang="{html.escape(spoken().language)}"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{LOCKED}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{html.escape(title)}</title><style>{sheet}{_symbol_colours()}</style></head><body>\n"
        + "\n".join(parts)
        + "\n</body></html>\n"
    )


def entry_html(entry: ReportEntry, rich: Callable[[str], str]) -> str:
    """Return one step of a report; see `report_html` for `rich`."""
    parts: list[str] = []

    def add(name: str, content: str) -> None:
        parts.append(f"<dt>{html.escape(name)}</dt><dd>{content}</dd>")

    if entry.question:
        add(tr("Question"), rich(entry.question))
    if entry.prediction:
        mark = "" if entry.right is None else _mark(entry.right, tr("right"), tr("not so"))
        add(tr("Prediction"), mark + rich(entry.prediction))
    if entry.drawing:
        _check_svg(entry.drawing)
        add(tr("Drawn"), f'<figure class="drawing">{entry.drawing}</figure>{html.escape(entry.drawing_verdict)}')
    measured = _list([rich(line) for line in entry.outcome])
    if entry.because.strip():
        reason = f"<div><b>{html.escape(tr('Because'))}</b><p>{html.escape(entry.because)}</p></div>"
        outcome = f"<div><b>{html.escape(tr('Measured'))}</b>{measured}</div>" if entry.outcome else ""
        add(tr("Reason and outcome"), f'<div class="beside">{reason}{outcome}</div>')
    elif entry.outcome:
        add(tr("Measured"), measured)
    if entry.verdict:
        add(tr("Verdict"), rich(entry.verdict))
    if entry.passed is not None:
        tries = f"{html.escape(tr('attempts'))}: {entry.attempts}" if entry.attempts else ""
        lines = [("✓ " if met else "✗ ") + rich(line) for line, met in entry.judgements]
        add(tr("Challenge"), _mark(entry.passed, tr("passed"), tr("not passed")) + tries + (_list(lines) if lines else ""))
    if entry.settings:
        add(tr("Settings"), lowered(html.escape(entry.settings)))
    if entry.words.strip():
        add(tr("In my own words"), f'<span class="words">{html.escape(entry.words)}</span>')
    if entry.plot:
        _check_svg(entry.plot)
    plot = f"<figure>{entry.plot}</figure>" if entry.plot else ""
    return f"<article><h3>{html.escape(entry.title)}</h3><dl>{''.join(parts)}</dl>{plot}</article>"


def _symbol_colours() -> str:
    """Return the rules for the symbols in formulas: on paper as on the page."""
    light = PALETTES["light"]
    symbols = {
        "lam": light.activation,
        "dm": light.critical,
        "v": light.velocity,
        "u": light.pull,
        "w": light.approach,
        "d": light.distance,
        "e": light.error,
    }
    return "".join(f"svg .{name} {{ color: {colour}; }}\n" for name, colour in symbols.items())


def _mark(good: bool, yes: str, no: str) -> str:
    return f'<span class="mark {"right" if good else "wrong"}">{"✓" if good else "✗"} {html.escape(yes if good else no)}</span>'


def _list(lines: list[str]) -> str:
    return f"<ul>{''.join(f'<li>{line}</li>' for line in lines)}</ul>"


_FOREIGN: Final = frozenset({"script", "foreignObject", "iframe", "image", "a", "animate", "set"})


def _check_svg(svg: str) -> None:
    try:
        root = ET.fromstring(svg)
    except ET.ParseError as error:
        raise ValueError(f"a plot is no <svg> element: {error}") from None
    names = [element.tag.rpartition("}")[2] for element in root.iter()]
    keys = [key for element in root.iter() for key in element.attrib]
    if names[0] != "svg" or _FOREIGN.intersection(names) or any(key.lower().startswith("on") for key in keys):
        raise ValueError("a plot is no plain <svg> element: only shapes and text belong there")


def _table(settings: Settings) -> str:
    head = "".join(f"<th>{html.escape(name)}</th>" for name in (tr("setting"), tr("value"), tr("meaning")))
    present = values(settings.run)
    rows = "".join(
        f"<tr><td>{lowered(html.escape(tr(spec.label)))}</td><td>{html.escape(page_value(key, present[key]))}</td>"
        f"<td>{html.escape(tr(spec.help))}</td></tr>"
        for key, spec in specs(RunSettings).items()
        if matters(key, settings)
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"


def lowered(escaped: str) -> str:
    """Return text with its subscripts: d_m → d<sub>m</sub>."""
    return re.sub(r"(?<!\w)([^\W\d_])_([A-Za-z0-9]{1,5})(?!\w)", r"\1<sub>\2</sub>", escaped)
