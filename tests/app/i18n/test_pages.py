"""Pages and exports in other languages, without a browser."""

import html
import re
from collections.abc import Iterator
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
from app.i18n.speaking import set_language, tr
from app.lessons.curve_drawing import DrawingVerdict, DrawnCurves
from app.lessons.loading import load_lessons
from app.lessons.outcomes import AnswerVerdict
from app.settings import Details, Settings
from app.text.lesson_text import plain
from scenes.settings import RunSettings, changed
from tests.app.conftest import Arrive, Guest, OpenHouse, ask
from tests.app.i18n.conftest import untranslated
from tests.app.lessons.helpers import much_done
from tests.app.page.helpers import bodies, notes, open_lessons
from tests.app.recording.runs import piece, read_film
from tests.blocking_client import BlockingClient

TEXTS = ("label", "hint", "content", "options", "_tab_labels", "title", "body", "description")


def texts(visitor: BlockingClient) -> Iterator[str]:
    for element in [*list(visitor.mirror.gui.values()), *list(visitor.mirror.commands.values())]:
        for found in map(element.get, TEXTS):
            yield from (text for text in ([found] if isinstance(found, str) else found or ()) if isinstance(text, str))


def comes(visitor: BlockingClient, word: str) -> None:
    visitor.wait_for(lambda _: any(word in text for text in texts(visitor)))


def labels(visitor: BlockingClient) -> list[str]:
    return [str(element["label"]) for element in list(visitor.mirror.gui.values()) if element.get("label")]


def assert_all_said(visitor: BlockingClient) -> None:
    left = {text[:120]: words for text in texts(visitor) if (words := untranslated(text))}
    assert left == {}


def choose(guest: Guest, **values: object) -> None:
    ask(guest.session, lambda s: [s.change(key, value) for key, value in values.items()])
    guest.run_on(0.2)


def test_in_pseudo_nothing_is_left_untranslated(house: OpenHouse, arrive: Arrive) -> None:
    guest = arrive(house(), "lang=pseudo&details=none&speed=2")
    assert_all_said(guest.visitor)
    choose(guest, ghost="frozen", whatif=True)
    for scene, plot, law in (
        *(("solo", "joints", "smooth_priority"), ("ball", "curve", "null_space_avoidance"), ("hold", "laws", "barrier_qp")),
        *(("hold", "map", "strict_switched"), ("master_slave", "follow", "potential_field")),
        *(("hold", "speeds", "strict_priority"), ("imitation", "follow", "unprotected")),
        *(("imitation", "pairs", "intermediate_value"), ("hold", "stability", "smooth_priority")),
        ("hold", "stability", "barrier_qp"),
    ):
        choose(guest, scene=scene, plot=plot, law=law)
        assert_all_said(guest.visitor)
    ask(guest.session, lambda s: s.measure_smoothness())
    choose(guest, scene="imitation", source="camera")
    assert_all_said(guest.visitor)


def test_a_bad_link_is_named_controls_work_and_the_language_changes_on_the_page(house: OpenHouse, arrive: Arrive) -> None:
    guest = arrive(house(), "lang=sl&dm=9")
    visitor = guest.visitor
    visitor.wait_for(lambda _: notes(visitor))
    assert [note["title"] for note in bodies(visitor, "NotificationShowMessage")] == ["Del povezave je izpuščen"]
    assert "je zunaj območja; mogoče je število od" in notes(visitor)[0]
    visitor.set_value("prizor", "Žoga na poti (sl. 1)")
    guest.wait(lambda s: s.settings.run.scene == "ball")
    clock = visitor.mirror.labelled("ura")
    visitor.send({"type": "GuiUpdateMessage", "uuid": clock["uuid"], "updates": {"value": "Premor"}})
    guest.wait(lambda s: s.paused)
    comes(visitor, "ustavljeno")
    visitor.set_value("jezik", "English")
    open_lessons(visitor)
    comes(visitor, "Leave the lessons")
    visitor.set_value("language", "Slovenščina")
    title = plain(load_lessons(language="sl").lessons[0].steps[0].title)
    for word in ("Zapusti lekcije", title, "Lekcija: zapusti lekcije"):
        comes(visitor, word)
    own, others = ("jezik", "prizor", "zakon", "ura"), {"language", "scene", "law", "clock", "Leave the lessons"}
    visitor.wait_for(lambda _: [labels(visitor).count(label) for label in own] == [1] * 4 and not others & set(labels(visitor)))


SYMBOLS = frozenset({"mathrm", "λρ²"})


@pytest.mark.parametrize(
    ("scene", "details"),
    [
        *(("hold", "curve"), ("hold", "laws"), ("hold", "pairs"), ("hold", "stability"), ("master_slave", "follow")),
        *(("imitation", "follow"), ("imitation", "stability"), ("solo", "joints")),
    ],
)
def test_pictures(scene: str, details: Details) -> None:
    recorded, _ = piece(scene, 1.0)
    set_language("pseudo")
    with matplotlib.rc_context(STYLE):
        figure = pictures._figure(recorded, 1.0, details, ())
    found = [text.get_text() for text in figure.findobj(Text) if isinstance(text, Text)]
    assert any("⟦" in text for text in found)
    assert {text: left for text in found if (left := [w for w in untranslated(text) if w not in SYMBOLS])} == {}


def test_pictures_are_drawn_in_a_worker_in_the_language_that_it_is_given() -> None:
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
    lesson, index, done = much_done("1")
    step = replace(lesson.steps[index], title="2")
    view = step_entry(Done(replace(lesson, title="3"), index, done)).view
    said = {"texts": (("predict", "4"),), "choices": ("5",) * 9, "verdict": AnswerVerdict(False, "6", "6", ()), "outcome": ("7",)}
    drawing = DrawnCurves(done.drawing, (), DrawingVerdict(False, "8"))
    view = replace(view, step=step, drawing=drawing, **said)
    page = report_html("9", [ReportEntry(view, _settings(run))], Settings(run=run), about=tr("Name"))
    body = re.sub(r"<style>.*?</style>", "", page[page.index("<body>") :], flags=re.DOTALL)
    assert untranslated(html.unescape(body)) == []
    set_language("de")
    page = report_html("Bericht", [], Settings())
    assert '<html lang="de">' in page and "<h2>Einstellungen des letzten Laufs</h2>" in page
