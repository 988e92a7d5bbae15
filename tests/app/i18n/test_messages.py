"""Errors for visitors, and the browser's own messages, are in the page's language."""

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
from app.settings import LANGUAGES, Language
from controllers.errors import BadInputFile, BadSetting, DuetError, LazyText, joined
from scenes.settings import RunSettings, changed
from tests.app.i18n.conftest import untranslated
from tests.app.i18n.helpers import refusal
from tests.app.recording.runs import piece
from tests.approved import Approve, case_lines

RUN = saved_bytes(piece("hold", 1.0)[0])


def nested() -> tuple[BadSetting, BadInputFile]:
    """An error, and another one that contains it."""
    inner = BadSetting(
        "{key} = {value} is not a number; {remedy}", key="n", value="'x'", remedy="{as it stands}"
    )
    return inner, BadInputFile("{name}: {reason}", name="{odd}.npz", reason=str(inner))


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_message_is_translated_into_each_language(language: Language, approve: Approve) -> None:
    messages = {
        "out of range": refusal(lambda: changed(RunSettings(), "dm", "9")),
        "made of another": str(nested()[1]),
        "loaded run": load_run(RUN, "a").words,
    }
    words = words_of(language)
    approve(f"messages {language}.txt", case_lines({case: words(text) for case, text in messages.items()}))


def test_a_message_in_english_is_its_own_text() -> None:
    said = refusal(lambda: changed(RunSettings(), "dm", "9"))
    assert words_of("en")(said) == said


def test_a_message_keeps_its_parts() -> None:
    inner, outer = nested()
    again = pickle.loads(pickle.dumps(outer))
    assert str(again) == str(outer) and str(inner) in str(outer)
    for language in LANGUAGES:
        assert words_of(language)(str(again)) == words_of(language)(str(outer))
    assert LazyText(outer.args[0]).parts == outer.args[0].parts
    # Without parts nothing is filled in, and only a text counts as a text.
    assert str(BadSetting("a {b} c")) == "a {b} c" and str(DuetError()) == ""
    assert (
        joined(("a", "", LazyText("off")), ", ") == "a, , off"
        and words_of("de")(joined([LazyText("off")], " ")) == "aus"
    )
    assert joined((), ", ") == ""
    # A message formatted into another text is a plain string, also if it is the whole text.
    assert {type(text) for text in (f"{inner}", f"{inner!s}", f"{inner!s:>90}")} == {str}


def test_a_loaded_run_is_compared_in_the_pages_language() -> None:
    change = Difference(3, 0.015, "d", 0.2, 0.3, 0.1)
    other = Comparison(False, 3, change, replace(change, column="pair"), 200, 190)
    made = changed_versions({"duet": "0", "system": "🦆"}, {"duet": "1", "system": "1"})
    set_language("pseudo")
    verdicts: tuple[Agreement, ...] = ("close", "differs", "differs")
    for verdict, differs in zip(verdicts, ((), made, changed_versions({}, {"machine": "1"})), strict=True):
        said = _words(verdict, other, differs, "m")
        # Names of columns and programs are not translated.
        assert {*untranslated(tr(said))} <= {"pair", "Pinocchio", "Python", "numpy"}


def test_the_page_knows_every_language() -> None:
    tables = translations()
    assert {name: set(table) for name, table in tables.items()} == {
        key: {*ALL} for key in ("de", "sl", "pseudo")
    }
    assert tables["de"][LOST].startswith("Verbindung verloren") and tables["pseudo"][LOST].startswith("⟦")
    # Texts that the scripts translate themselves.
    assert {*ICON_NAMES.values(), "more", "dismiss this message"} <= set(OURS)


def test_the_listed_texts_of_viser_are_in_its_sources() -> None:
    """If another version of viser has other words, update the list in `app.i18n.client_texts`."""
    built = Path(inspect.getfile(viser)).parent / "client" / "src"
    if not built.is_dir():
        pytest.skip("this viser comes without its sources")
    sources = " ".join(" ".join(path.read_text(encoding="utf-8").split()) for path in built.rglob("*.tsx"))
    sources = sources.replace('" + "', "").replace("&apos;", "'").replace("”", '"')
    gone = [english for english in VISERS if "{" not in english and english not in sources]
    assert gone == []
