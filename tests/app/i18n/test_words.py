"""The catalogues, the current language, and the language of a browser."""

import re
import threading
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.i18n.catalogue import FOLDER, Words, read_texts, words_of
from app.i18n.pseudo import FIRST, GROWTH, LAST, pseudo
from app.i18n.reader_language import language_of, preferred
from app.i18n.sides import side
from app.i18n.speaking import set_language, tr
from app.lessons.loading import load_lessons
from app.lessons.translated_book import in_language
from app.plots.pair_strips import pair_name
from app.settings import Language, Settings
from scenes.settings import RunSettings, changed, specs
from scenes.simulation import Simulation
from tests.app.i18n.messages import BODIES, FORMULAS, JOINTS, NAMES, messages, missing

FILES: tuple[Language, ...] = ("de", "sl")

LABEL = 14
"""Most letters of a label before a control; longer ones are cut off."""


def parts(text: str) -> Counter[str]:
    return Counter(re.findall(r"\{[^{}]*\}|<[^>]*>|&\w+;", text))


@pytest.mark.parametrize("language", FILES)
def test_a_catalogue_is_complete_and_keeps_the_parts(language: Language) -> None:
    """A text that is missing belongs into app/i18n/<language>.toml; one that is left over belongs out of it."""
    texts, words = read_texts(FOLDER / f"{language}.toml"), words_of(language)
    assert missing(language) == () and set(texts) <= set(messages())
    assert {key: text for key, text in texts.items() if parts(key) != parts(text)} == {}
    assert {key for key, text in texts.items() if (key[-1] == " ") != (text[-1] == " ") or not text.strip()} == set()
    labels = {spec.label: words(spec.label) for spec in specs(Settings).values()}
    assert {label: text for label, text in labels.items() if len(text) > LABEL} == {}


def test_the_list_knows_what_is_said() -> None:
    found = set(messages())
    # A label, a hint, a choice; a literal; one by the name of a constant; a title; one of two; a row of buttons.
    assert {"your arm", "Which experiment.", "Hold pose", "paused", "Predict first", "avoidance first", "more plots"} <= found
    assert not found & (FORMULAS | NAMES)


def test_names_of_bodies_and_joints_are_on_the_list() -> None:
    set_language("pseudo")
    known = {word for body in BODIES for word in re.split(r"[⟦⟧· ]+", pseudo(body))}
    for scene, robot in (("hold", "lwr"), ("ball", "ur5")):
        simulation = Simulation(changed(changed(RunSettings(), "scene", scene), "robot", robot))
        assert set(simulation.avoiding.labels) <= set(JOINTS)
        for pair in range(simulation.detector.count):
            assert set(re.split(r"[⟦⟧·\d ]+", pair_name(simulation, pair))) <= known


def test_what_is_not_known_stays_english() -> None:
    words = Words("de", {"Law": "Gesetz", "{a} of {b}": "{a} von {c}"})
    assert words("Law") == "Gesetz" and words("Never heard") == "Never heard" and words("Key: {key}", key="R") == "Key: R"
    # A mistake in a file costs the translation, not the page.
    assert words("{a} of {b}", a=1, b=2) == "1 of 2"
    assert words_of("sl")("lesson\x04Run") == "Zaženi"
    assert words_of("en")("lesson\x04Run") == "Run" and words_of("auto")("Law") == "Law"


@pytest.mark.parametrize("content", ['"a" = 3', '"a" = "b"\n"a" = "c"', "a b c", '[part]\n"a" = "b"'])
def test_a_broken_file(content: str, tmp_path: Path) -> None:
    path = tmp_path / "xx.toml"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(ValueError):
        read_texts(path)


def test_every_thread_has_its_own_language() -> None:
    barrier = threading.Barrier(3)

    def visit(language: Language) -> str:
        set_language(language)
        barrier.wait(30.0)
        return tr("paused")

    with ThreadPoolExecutor(3) as threads:
        assert list(threads.map(visit, ("de", "sl", "en"))) == ["angehalten", "ustavljeno", "paused"]
    assert tr("paused") == "paused" and (side("left"), side("right"), side("arm")) == ("left", "right", "arm")
    set_language("de")
    assert (side("left"), side("right"), tr("right")) == ("links", "rechts", "richtig")


@given(st.text("abc XYZ<>{}&;.1", max_size=60))
def test_pseudo_keeps_what_is_no_text_and_is_longer_and_marked(text: str) -> None:
    said = pseudo(text)
    assert parts(said) == parts(text) and pseudo(said) == said and pseudo("150") == "150" and pseudo("λ") == "λ"
    for text in ("Distance", "Reset {what} in <b>{d}</b> mm", "Smooth: half the time step, half the largest step."):
        shown = pseudo(text)
        assert shown.startswith(FIRST) and shown.endswith(LAST)
        assert len(shown) - len(text) >= round(GROWTH * len(re.sub(r"\{[^{}]*\}|<[^>]*>", "", text)))


@pytest.mark.parametrize(
    ("accept", "language"),
    [
        *(("", "en"), ("de", "de"), ("de-AT", "de"), ("SL", "sl"), ("*", "en"), ("de;q=1.5", "en"), ("," * 5000, "en")),
        *(("de-AT,de;q=0.9,en;q=0.8", "de"), ("fr, it", "en"), ("fr, sl;q=0.5, en;q=0.4", "sl"), ("en;q=0.3, de;q=0.7", "de")),
        *(("de;q=0, sl;q=0.1", "sl"), ("fr;q=1, *;q=0.5", "en"), ("sl ; q=0.7 , de; q=0.2", "sl")),
        ("de;q=nan, sl;q=two, ;;;,=,q", "en"),
    ],
)
def test_what_a_browser_likes_best(accept: str, language: str) -> None:
    assert preferred(accept) == language
    # A choice by link or on the page goes before it.
    assert language_of(Settings(), preferred(accept)) == language and language_of(changed(Settings(), "lang", "de"), "sl") == "de"


@given(st.text(max_size=200))
def test_any_header_gives_a_language(accept: str) -> None:
    assert preferred(accept) in ("en", "de", "sl")


@pytest.mark.parametrize("language", FILES)
def test_lessons_in_other_languages(language: Language) -> None:
    book = load_lessons()
    other = in_language(book, language)
    assert not other.problems
    assert [lesson.id for lesson in other.lessons] == [lesson.id for lesson in book.lessons]
    assert {lesson.language for lesson in other.lessons} == {language}
    assert all(own.title != lesson.title for own, lesson in zip(other.lessons, book.lessons, strict=True))
    assert in_language(book, "en") is book and in_language(book, "pseudo") is book
