"""A lab report as one HTML page that prints well: predictions beside outcomes, plots, settings, and a student's own words.

What it says to a program is an element that shows nothing and runs nothing, with one entry a step. It is as easy to change as the rest of
the page: a report can be forged.
"""

import html
import json
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Annotated, Final

import msgspec
from markupsafe import Markup, escape

from app.export.gain import QuestionGain, whole
from app.i18n.speaking import spoken, tr
from app.lessons.runs import page_value
from app.recording.run_file import made_here
from app.session.relevant_settings import matters
from app.settings import Settings
from app.text.templates import element, page_of_template
from app.theme import css_variables, symbol_rules
from controllers.errors import LazyText
from scenes.settings import RunSettings, specs, values

LOCKED: Final = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
"""The page may load nothing and run nothing."""

LARGEST_REPORT: Final = 32 * 2**20
"""Largest report that is read [bytes]."""

_RECORD: Final = re.compile(rb'<template id="duet-report" data-record="([^"<>]{1,400000})">')
_MOST_STEPS: Final = 500

_Name = Annotated[str, msgspec.Meta(pattern=r"\A[a-z0-9_-]{1,60}\Z")]
_Count = Annotated[int, msgspec.Meta(ge=0, lt=1_000_000)]


@dataclass(frozen=True)
class StepRecord:
    """What was done in one step.

    Attributes:
        lesson, step: by name.
        prediction: number of the answer that was chosen, from 1; None for none.
        right: whether it was right; None if the outcome was not seen.
        passed: whether the challenge was passed; None if there is none.
        attempts: at the challenge.
    """

    lesson: _Name
    step: _Name
    prediction: _Count | None
    right: bool | None
    passed: bool | None
    attempts: _Count


_NAMES: Final = [one.name for one in fields(StepRecord)]


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


def records_html(records: Sequence[StepRecord]) -> Markup:
    """Return the element; "" for no records."""
    if not records:
        return Markup()
    data = {"version": 1, "columns": _NAMES, "steps": [astuple(record) for record in records]}
    return element("template", id="duet-report", data_record=json.dumps(data))


def read_records(page: bytes) -> tuple[StepRecord, ...]:
    """Return the records of a report.

    Raises:
        ValueError: it has none, or they are not as `records_html` writes them.
    """
    found = _RECORD.search(page)
    if found is None:
        raise ValueError(LazyText("is no lab report of Duet, or one of an older version"))
    try:
        data = json.loads(html.unescape(found[1].decode()))
        if data["version"] != 1 or data["columns"] != _NAMES or len(data["steps"]) > _MOST_STEPS:
            raise ValueError
        records = tuple(msgspec.convert(dict(zip(_NAMES, step, strict=True)), StepRecord) for step in data["steps"])
    except (ValueError, KeyError, TypeError, RecursionError, msgspec.ValidationError):
        raise ValueError(LazyText("its record is damaged")) from None
    if len({(record.lesson, record.step) for record in records}) < len(records):
        raise ValueError(LazyText("its record has a step twice"))
    return records
