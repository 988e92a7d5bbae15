"""A lab report as one HTML page that prints well: predictions beside outcomes, plots, settings, and a student's own words."""

import xml.etree.ElementTree as ET
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from markupsafe import Markup, escape

from app.export.gain import QuestionGain, whole
from app.export.report_record import StepRecord, records_html
from app.i18n.speaking import spoken, tr
from app.lessons.runs import page_value
from app.recording.run_file import made_here
from app.session.relevant_settings import matters
from app.settings import Settings
from app.text.templates import page_of_template
from app.theme import css_variables, symbol_rules
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
    rich: Callable[[str], str] = escape,
    questions: Sequence[QuestionGain] = (),
) -> str:
    """Return the page. Nothing in it loads anything or runs, and everything that a person wrote is escaped.

    Args:
        entries: the steps, in order.
        settings: of the last run; None to leave them out.
        about: one line under the title, such as a name and a date.
        rich: makes HTML of a text of the lesson's author (question, prediction, verdict, outcome, judgement), for formulas; the
            title, `about` and all words of the student are escaped whatever it is.
        questions: of a test that the student has answered before and after.

    Raises:
        ValueError: a plot is no plain <svg> element.
    """
    made = f"{tr('Made by Duet')} {made_here()['duet']}"
    return locked_page(
        "export/report.html",
        title,
        ("report.css",),
        about=f"{about} · {made}" if about else made,
        entries=entries,
        rich=lambda text: Markup(rich(text)),
        svg=plain_svg,
        questions=questions,
        total=whole(questions),
        settings=None if settings is None else _rows(settings),
        records=records_html([entry.record for entry in entries if entry.record is not None]),
    )


def locked_page(template: str, title: str, styles: Sequence[str], **values: object) -> str:
    """Return an HTML page that loads and runs nothing, in the reader's language.

    Args:
        template: that extends "export/page.html".
        styles: names of style sheets in this folder.
        values: that the template names.
    """
    files = "".join(Path(__file__).with_name(name).read_text(encoding="utf-8") for name in styles)
    sheet = Markup(f":root{{color-scheme:only light}}{css_variables()}{files}{symbol_rules('svg')}")
    return page_of_template(template, title=title, language=spoken().language, locked=Markup(LOCKED), sheet=sheet, **values)


_FOREIGN: Final = frozenset({"script", "foreignObject", "iframe", "image", "a", "animate", "set"})


def plain_svg(svg: str) -> Markup:
    """Return an <svg> element as it is, which holds shapes and text alone.

    Raises:
        ValueError: it holds anything else.
    """
    try:
        root = ET.fromstring(svg)
    except ET.ParseError as error:
        raise ValueError(f"a plot is no <svg> element: {error}") from None
    names = [element.tag.rpartition("}")[2] for element in root.iter()]
    keys = [key for element in root.iter() for key in element.attrib]
    if names[0] != "svg" or _FOREIGN.intersection(names) or any(key.lower().startswith("on") for key in keys):
        raise ValueError("a plot is no plain <svg> element: only shapes and text belong there")
    return Markup(svg)


def _rows(settings: Settings) -> list[tuple[str, str, str]]:
    """Return label, value and meaning of the settings that matter."""
    present, known = values(settings.run), specs(RunSettings).items()
    return [(spec.label, page_value(key, present[key]), spec.help) for key, spec in known if matters(key, settings)]
