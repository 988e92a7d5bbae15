"""Exports are in the visitor's language: pictures, the report, the player."""

import html
import re

import matplotlib
import pytest
from matplotlib.text import Text

from app.export import jobs
from app.export import plot_pictures as pictures
from app.export.lab_report import _settings
from app.export.player import assembled, packed_film
from app.export.recorded_curves import Curves
from app.export.report_html import ReportEntry, report_html
from app.export.scene_film import Filmed
from app.figures.figure_style import STYLE
from app.i18n.catalogue import words_of
from app.i18n.speaking import set_language, tr
from app.settings import Details, Settings
from app.text.documents import DOCUMENTS, document_page
from scenes.rerun import never
from scenes.settings import RunSettings, changed
from tests.app.export.runs import piece, read_film
from tests.app.i18n.conftest import untranslated

SYMBOLS = frozenset({"mathrm", "λρ²"})


@pytest.mark.parametrize(
    ("scene", "details"),
    [
        *(("hold", "curve"), ("hold", "laws"), ("hold", "pairs"), ("hold", "stability"), ("master_slave", "follow")),
        *(("imitation", "follow"), ("imitation", "stability"), ("solo", "joints")),
    ],
)
def test_pictures(scene: str, details: Details) -> None:
    recorded, table = piece(scene, 1.0)
    own = table if details not in ("curve", "laws", "stability") else None
    set_language("pseudo")
    with matplotlib.rc_context(STYLE):
        figure = pictures._figure(recorded, 1.0, details, own, never)
    found = [text.get_text() for text in figure.findobj(Text) if isinstance(text, Text)]
    assert any("⟦" in text for text in found)
    assert {text: left for text in found if (left := [w for w in untranslated(text) if w not in SYMBOLS])} == {}


def test_pictures_are_drawn_in_a_worker_in_the_language_that_it_is_given() -> None:
    recorded, table = piece("hold", 1.0)
    arguments = recorded, 1.0, "none", "svg", table
    made = {language: jobs.picture(language, *arguments) for language in ("en", "de", "sl", "en")}
    assert len({*made.values()}) == 3 and jobs.picture("de", *arguments) == made["de"]


def test_the_page_that_plays() -> None:
    recorded, table = piece("hold", 1.0)
    set_language("pseudo")
    panels = Curves(recorded, table).panels("pairs")
    filmed = Filmed(b"", (), (0.0, 0.05))
    page = assembled(filmed, panels, recorded.settings, False)
    assert '<html lang="en" data-words="pseudo">' in page
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
    assert '<html lang="de" data-words="de">' in page and 'aria-label="Abspielen"' in page and "Halten (Abb. 5)" in page


def test_the_report() -> None:
    set_language("pseudo")
    run = changed(changed(RunSettings(), "law", "barrier_qp"), "scene", "ball")
    entry = ReportEntry("1", "1", "2", False, "4", ("3",), (("5", True),), 2, True, "6", settings=_settings(run))
    page = report_html("7", [entry], Settings(run=run), about=tr("Name"))
    body = re.sub(r"<style>.*?</style>", "", page[page.index("<body>") :], flags=re.DOTALL)
    assert untranslated(html.unescape(body)) == []
    set_language("de")
    page = report_html("Bericht", [], Settings())
    assert '<html lang="de">' in page and "<h2>Einstellungen des letzten Laufs</h2>" in page


@pytest.mark.parametrize("name", DOCUMENTS)
def test_the_frame_of_the_documents(name: str) -> None:
    page = document_page(name, "pseudo").decode()
    frame = page[: page.index("<main")] + page[page.index("</main>") :]
    assert '<html lang="en">' in page and '<main lang="en">' in page
    assert untranslated(re.sub(r"<style>.*?</style>", "", frame, flags=re.DOTALL)) == []
    german = document_page(name, "de").decode()
    assert '<html lang="de">' in german and words_of("de")(DOCUMENTS[name][1]) in german
    assert 'lang="en"' not in document_page(name).decode().split("<main")[1]
