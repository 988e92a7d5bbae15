"""Offline pages, and a lab report's machine-readable records.

The records are an invisible element with an entry per step. They can be forged.
"""

import html
import json
import re
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Annotated, Final

import msgspec
from markupsafe import Markup

from app.i18n.speaking import spoken
from app.text.templates import element, page_of_template
from app.theme import css_variables, symbol_rules
from controllers.errors import LazyText

LOCKED: Final = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
"""Content policy: the page loads and runs nothing."""

LARGEST_REPORT: Final = 32 * 2**20
"""Largest report that is read [bytes]."""

_RECORD: Final = re.compile(rb'<template id="duet-report" data-record="([^"<>]{1,400000})">')
_MOST_STEPS: Final = 500

_Name = Annotated[str, msgspec.Meta(pattern=r"\A[a-z0-9_-]{1,60}\Z")]
_Count = Annotated[int, msgspec.Meta(ge=0, lt=1_000_000)]


@dataclass(frozen=True)
class StepRecord:
    """Work in one step.

    Attributes:
        prediction: chosen answer (1-based), or None.
        right: None if the outcome was not seen.
        passed: None without a challenge.
    """

    lesson: _Name
    step: _Name
    prediction: _Count | None
    right: bool | None
    passed: bool | None
    attempts: _Count


_NAMES: Final = [one.name for one in fields(StepRecord)]


SHEET: Final = Path(__file__).with_name("report.css")


def locked_page(template: str, title: str, styles: Sequence[Path], **values: object) -> str:
    """HTML page that loads and runs nothing. `template`: extends "features/lab_report/page.html"."""
    files = "".join(file.read_text(encoding="utf-8") for file in styles)
    sheet = Markup(f":root{{color-scheme:only light}}{css_variables()}{files}{symbol_rules('svg')}")
    return page_of_template(
        template, title=title, language=spoken().language, locked=Markup(LOCKED), sheet=sheet, **values
    )


_FOREIGN: Final = frozenset({"script", "foreignObject", "iframe", "image", "a", "animate", "set"})


def plain_svg(svg: str) -> Markup:
    """`svg` unchanged.

    Raises:
        ValueError: not an <svg> element of only shapes and text.
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


def records_html(records: Sequence[StepRecord]) -> Markup:
    """Element with the records; "" without records."""
    if not records:
        return Markup()
    data = {"version": 1, "columns": _NAMES, "steps": [astuple(record) for record in records]}
    return element("template", id="duet-report", data_record=json.dumps(data))


def read_records(page: bytes) -> tuple[StepRecord, ...]:
    """Records of a report.

    Raises:
        ValueError: no records, or not as `records_html` writes them.
    """
    found = _RECORD.search(page)
    if found is None:
        raise ValueError(LazyText("is not a lab report of Duet, or is from an older version"))
    try:
        data = json.loads(html.unescape(found[1].decode()))
        if data["version"] != 1 or data["columns"] != _NAMES or len(data["steps"]) > _MOST_STEPS:
            raise ValueError
        records = tuple(
            msgspec.convert(dict(zip(_NAMES, step, strict=True)), StepRecord) for step in data["steps"]
        )
    except (ValueError, KeyError, TypeError, RecursionError, msgspec.ValidationError):
        raise ValueError(LazyText("its record is damaged")) from None
    if len({(record.lesson, record.step) for record in records}) < len(records):
        raise ValueError(LazyText("its record has a step twice"))
    return records
