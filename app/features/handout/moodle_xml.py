r"""Predictions of a lesson as multiple choice, and forecasts as numbers, in Moodle XML.

Formulas stay LaTeX, between \( and \), for Moodle's MathJax filter. Format: docs.moodle.org, Moodle XML
format.
"""

import re
from collections.abc import Iterator
from html import escape
from typing import Final
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from app.features.handout.handout_html import PaperStep, told
from app.features.lab_report.lab_report import lesson_title
from app.features.lessons.labels import label_of
from app.features.lessons.lesson import Challenge, Lesson, Question
from app.features.lessons.reference_runs import measured
from app.features.lessons.runs import settings_text
from app.features.measures.quantities.quantity import UNITS
from app.i18n.speaking import tr
from app.text.lesson_text import markdown_reader, plain
from app.text.templates import element

_READER: Final = markdown_reader()
for _rule, _marks in {
    "formula": ("\\(", "\\)"),
    "formula_display": ("\\[", "\\]"),
    "formula_block": ("\\[", "\\]"),
}.items():
    _READER.add_render_rule(
        _rule,
        lambda _, tokens, at, *__, marks=_marks: marks[0] + escape(tokens[at].content.strip()) + marks[1],
    )
# A file would have to be uploaded by hand; the picture's description replaces it.
_READER.add_render_rule("picture", lambda _, tokens, at, *__: element("p", tokens[at].content))

NO_UNITS: Final = "3"
"""The answer is a bare number; the question has its unit."""


NOT_IN_XML: Final = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML forbids, even as references (XML 1.0, section 2.2)."""


def moodle_xml(lesson: Lesson) -> bytes:
    """File for Moodle's question bank, in the current language."""
    quiz = Element("quiz")
    category = SubElement(quiz, "question", type="category")
    _text(
        category,
        "category",
        f"$course$/top/Duet/{lesson.number:02d} {plain(lesson_title(lesson)).replace('/', '//')}",
    )
    for i, step in enumerate(lesson.steps):
        paper = PaperStep(lesson, i, told(step))
        if step.question is not None and step.question.choices:
            quiz.append(_multiple_choice(paper, step.question))
        if step.challenge is not None:
            quiz.extend(_numerical(paper, step.challenge))
    indent(quiz)
    text = tostring(quiz, encoding="unicode")
    return f"<?xml version='1.0' encoding='utf-8'?>\n{NOT_IN_XML.sub('', text)}".encode()


def _multiple_choice(paper: PaperStep, question: Question) -> Element:
    made = _question("multichoice", paper, paper.number, f"{paper.step.do}\n\n{question.text}")
    for name, value in {"single": "true", "shuffleanswers": "true", "answernumbering": "abc"}.items():
        SubElement(made, name).text = value
    for place, choice in enumerate(question.choices):
        answer = _html(
            made, "answer", paper.filled(choice.text), fraction="100" if place == question.right else "0"
        )
        # The last test reveals the right answers.
        _html(answer, "feedback", "" if paper.step.asked == "first" else paper.filled(choice.reply))
    for hint in paper.step.hints:
        _html(made, "hint", paper.filled(hint))
    return made


def _numerical(paper: PaperStep, challenge: Challenge) -> Iterator[Element]:
    for place, forecast in enumerate(challenge.forecasts, 1):
        m, language = forecast.measurement, paper.lesson.language
        value = measured(challenge.setup.with_changes(forecast.changes), m.name, m.parameters)
        if value is None:
            continue
        _, factor, unit = UNITS[m.unit]
        asked = tr(
            "With {settings}: {what}?",
            settings=settings_text(forecast.changes, language),
            what=label_of(m, language),
        )
        text = f"{challenge.text}\n\n{asked}" + (f" [{unit}]" if unit else "")
        made = _question("numerical", paper, f"{paper.number}.{place}", text)
        answer = SubElement(made, "answer", fraction="100", format="moodle_auto_format")
        SubElement(answer, "text").text = f"{value * factor:.{m.digits}f}"
        SubElement(answer, "tolerance").text = f"{abs(value * factor) * forecast.within:.3g}"
        SubElement(made, "showunits").text = NO_UNITS
        yield made


def _question(kind: str, paper: PaperStep, number: str, text: str) -> Element:
    """Elements common to both kinds. `text`: Markdown, not filled in yet."""
    made = Element("question", type=kind)
    _text(made, "name", f"{number} {plain(paper.step.title)}")
    _html(made, "questiontext", paper.filled(text))
    _html(made, "generalfeedback", paper.filled(paper.step.explain))
    for name, value in {"defaultgrade": "1", "penalty": "0.3333333", "hidden": "0"}.items():
        SubElement(made, name).text = value
    return made


def _text(parent: Element, name: str, text: str) -> Element:
    made = SubElement(parent, name)
    SubElement(made, "text").text = text
    return made


def _html(parent: Element, name: str, markdown: str, **attributes: str) -> Element:
    made = _text(parent, name, _READER.render(markdown).strip())
    made.attrib.update(attributes, format="html")
    return made
