"""Exports and reports in other languages."""

import html
import re
from dataclasses import replace

import matplotlib
import pytest
from matplotlib.text import Text

from app.features.exports import plot_pictures as pictures
from app.features.exports.export_queue import make_picture
from app.features.exports.player import assembled, packed_film
from app.features.exports.recorded_curves import Curves
from app.features.exports.scene_film import Filmed
from app.features.figures.drawn_figure import STYLE
from app.features.lab_report.lab_report import Done, ReportEntry, _settings, report_html, step_entry
from app.features.lessons.curve_drawing import DrawingVerdict, DrawnCurves
from app.features.lessons.outcomes import AnswerVerdict
from app.i18n.speaking import set_language, tr
from app.settings import Details, Settings
from scenes.settings import RunSettings, changed
from tests.app.features.lessons.helpers import much_done
from tests.app.i18n.conftest import untranslated
from tests.app.recording.runs import piece, read_film

SYMBOLS = frozenset({"mathrm", "λρ²"})


@pytest.mark.parametrize(
    ("scene", "details"),
    [
        *(
            ("hold", "curve"),
            ("hold", "laws"),
            ("hold", "pairs"),
            ("hold", "stability"),
            ("master_slave", "follow"),
        ),
        *(("imitation", "follow"), ("imitation", "stability"), ("solo", "joints")),
    ],
)
def test_pictures(scene: str, details: Details) -> None:
    recorded, _ = piece(scene, 1.0)
    set_language("pseudo")
    with matplotlib.rc_context(STYLE):
        figure = pictures.picture_figure(recorded, 1.0, details, ())
    found = [text.get_text() for text in figure.findobj(Text) if isinstance(text, Text)]
    assert any("⟦" in text for text in found)
    assert {
        text: left for text in found if (left := [w for w in untranslated(text) if w not in SYMBOLS])
    } == {}


def test_pictures_are_drawn_in_a_worker_in_the_requested_language() -> None:
    recorded, _ = piece("hold", 1.0)
    arguments = recorded, 1.0, "none", "svg"
    made = {language: make_picture(language, *arguments) for language in ("en", "de", "sl")}
    assert len({*made.values()}) == 3 and make_picture("de", *arguments) == made["de"]


def test_the_page_that_plays() -> None:
    recorded, table = piece("hold", 1.0)
    set_language("pseudo")
    panels = Curves(recorded, table).panels("pairs")
    filmed = Filmed(b"", (), (0.0, 0.05))
    page = assembled(filmed, panels, recorded.settings, False)
    assert re.search('<html lang="en" .*"pseudo"', page)
    own = page[page.index('<section id="duet-plots"') :]
    said = re.findall(r'aria-label="([^"]*)"', own)
    said += [re.sub(r"<(script|style).*?</\1>|<[^>]*>", "\n", own, flags=re.DOTALL)]
    assert said[0].startswith("⟦") and len(said) == 5
    assert [left for text in said if (left := untranslated(html.unescape(text)))] == []
    film, _ = read_film(packed_film(filmed, panels))
    said = [*film["words"].values(), *(panel["title"] for panel in film["panels"])]
    said += [name for panel in film["panels"] for name in (*panel["rows"], panel["note"])]
    assert len(said) > 6 and [left for text in said if (left := untranslated(text))] == []
    set_language("de")
    page = assembled(filmed, Curves(recorded, table).panels("none"), recorded.settings, False)
    assert (
        re.search('<html lang="de" .*"de"', page)
        and 'aria-label="Abspielen"' in page
        and "Halten (Abb. 5)" in page
    )


def test_the_report() -> None:
    set_language("pseudo")
    run = changed(changed(RunSettings(), "law", "barrier_qp"), "scene", "ball")
    lesson, index, done = much_done("1")
    step = replace(lesson.steps[index], title="2")
    view = step_entry(Done(replace(lesson, title="3"), index, done)).view
    said = {
        "texts": (("predict", "4"),),
        "choices": ("5",) * 9,
        "verdict": AnswerVerdict(False, "6", "6", ()),
        "outcome": ("7",),
    }
    drawing = DrawnCurves(done.drawing, (), DrawingVerdict(False, "8"))
    view = replace(view, step=step, drawing=drawing, **said)
    page = report_html("9", [ReportEntry(view, _settings(run))], Settings(run=run), about=tr("Name"))
    body = re.sub(r"<style>.*?</style>", "", page[page.index("<body>") :], flags=re.DOTALL)
    assert untranslated(html.unescape(body)) == []
    set_language("de")
    page = report_html("Bericht", [], Settings())
    assert '<html lang="de">' in page and tr("Settings of the last run") in page
