"""What is wrong is said in the page's language: errors that a visitor may meet, and what the browser says by itself."""

import inspect
import pickle
from dataclasses import replace
from pathlib import Path

import pytest
import viser

from app.i18n.catalogue import words_of
from app.i18n.client_texts import ALL, ICON_NAMES, LOST, OURS, VISERS, translations
from app.i18n.speaking import set_language, tr
from app.recording.outcome import Comparison, Difference
from app.recording.run_file import Agreement, _words, changed_versions, load_run, saved_bytes
from controllers.errors import BadInputFile, BadSetting, DuetError, LazyText, joined
from scenes.settings import RunSettings, changed
from tests.app.i18n.conftest import untranslated
from tests.app.i18n.helpers import refusal
from tests.app.recording.runs import piece


def test_a_message_is_its_english_text_and_can_be_said_in_another() -> None:
    said = refusal(lambda: changed(RunSettings(), "dm", "9"))
    assert said == "dm = '9' is out of range; give a number from 0.03 to 0.3 m."
    assert (
        words_of("de")(said)
        == "dm = '9' liegt außerhalb des Bereichs; möglich ist eine Zahl von 0,03 bis 0,3 m."
    )
    assert words_of("sl")(said) == "dm = '9' je zunaj območja; mogoče je število od 0,03 do 0,3 m."
    assert words_of("en")(said) == said


def test_a_message_keeps_what_it_is_made_of() -> None:
    inner = BadSetting(
        "{key} = {value} is not a number; {remedy}", key="n", value="'x'", remedy="{as it stands}"
    )
    outer = BadInputFile("{name}: {reason}", name="{odd}.npz", reason=str(inner))
    for error in (outer, pickle.loads(pickle.dumps(outer))):
        assert str(error) == "{odd}.npz: n = 'x' is not a number; {as it stands}"
        assert words_of("de")(str(error)) == "{odd}.npz: n = 'x' ist keine Zahl; {as it stands}"
    assert LazyText(outer.args[0]).parts == outer.args[0].parts
    # Without parts nothing is filled in, and nothing of another kind is believed to be a text.
    assert str(BadSetting("a {b} c")) == "a {b} c" and str(DuetError()) == ""
    assert (
        joined(("a", "", LazyText("off")), ", ") == "a, , off"
        and words_of("de")(joined([LazyText("off")], " ")) == "aus"
    )
    assert joined((), ", ") == ""
    # What is put into another text is plain, also where that text is nothing else.
    assert {type(text) for text in (f"{inner}", f"{inner!s}", f"{inner!s:>90}")} == {str}


RUN = saved_bytes(piece("hold", 1.0)[0])


def test_a_loaded_run_is_compared_in_the_page_s_language() -> None:
    exact = load_run(RUN, "a").words
    assert words_of("de")(exact) == "Wiederholt: Alle 200 Schritte sind gleich, bis aufs letzte Bit."
    change = Difference(3, 0.015, "d", 0.2, 0.3, 0.1)
    other = Comparison(False, 3, change, replace(change, column="pair"), 200, 190)
    made = changed_versions({"duet": "0", "system": "🦆"}, {"duet": "1", "system": "1"})
    set_language("pseudo")
    verdicts: tuple[Agreement, ...] = ("close", "differs", "differs")
    for verdict, differs in zip(verdicts, ((), made, changed_versions({}, {"machine": "1"})), strict=True):
        said = _words(verdict, other, differs, "m")
        # Columns and programs have names.
        assert {*untranslated(tr(said))} <= {"pair", "Pinocchio", "Python", "numpy"}


def test_the_page_knows_every_language() -> None:
    tables = translations()
    assert {name: set(table) for name, table in tables.items()} == {
        key: {*ALL} for key in ("de", "sl", "pseudo")
    }
    assert tables["de"][LOST].startswith("Verbindung verloren") and tables["pseudo"][LOST].startswith("⟦")
    # What the scripts translate themselves.
    assert {*ICON_NAMES.values(), "more", "dismiss this message"} <= set(OURS)


def test_what_viser_says_is_what_viser_says() -> None:
    """Another version of viser with other words: see the list in `app.i18n.client_texts`."""
    built = Path(inspect.getfile(viser)).parent / "client" / "src"
    if not built.is_dir():
        pytest.skip("this viser comes without its sources")
    sources = " ".join(" ".join(path.read_text(encoding="utf-8").split()) for path in built.rglob("*.tsx"))
    sources = sources.replace('" + "', "").replace("&apos;", "'").replace("”", '"')
    gone = [english for english in VISERS if "{" not in english and english not in sources]
    assert gone == []
