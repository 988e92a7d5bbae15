"""The catalogues, the current language, and that of a browser."""

import ast
import re
import threading
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.i18n.catalogue import FIRST, GROWTH, LAST, Words, catalogues, pseudo, read_texts, words_of
from app.i18n.reader_language import language_of, preferred
from app.i18n.speaking import set_language, tr
from app.page.panels.controls import TABS
from app.page.panels.replay_bar import LENGTHS
from app.plots.pair_strips import arm_colour, pair_name
from app.settings import LANGUAGES, TRANSLATIONS, Language, Settings
from scenes.settings import RunSettings, changed, specs
from scenes.simulation import Simulation
from tests.app.i18n.messages import (
    BODIES,
    FORMULAS,
    JOINTS,
    NAMES,
    errors_of,
    left_over,
    messages,
    missing,
    on_the_page,
)

LABEL = 14
"""Longest label of a control [letters]; longer ones are cut off."""


def parts(text: str) -> Counter[str]:
    # The plural forms differ between languages.
    return Counter(re.findall(r"\{[^{}]*\}|<[^>]*>|&\w+;", re.sub(r":[^{}]*\|[^{}]*\}", "}", text)))


@pytest.mark.parametrize("language", TRANSLATIONS)
def test_a_catalogue_is_complete_and_keeps_the_parts(language: Language) -> None:
    """Add a missing text to the catalogue in the named folder; remove a left-over one from its catalogue."""
    texts, words = (
        {key: text for path in catalogues(language) for key, text in read_texts(path).items()},
        words_of(language),
    )
    assert missing(language) == {} and left_over(language) == []
    assert words.texts == texts
    assert {key: text for key, text in texts.items() if parts(key) != parts(text)} == {}
    assert {
        key for key, text in texts.items() if (key[-1] == " ") != (text[-1] == " ") or not text.strip()
    } == set()
    labels = {spec.label: words(spec.label) for spec in specs(Settings).values()}
    assert {label: text for label, text in labels.items() if len(text) > LABEL} == {}
    begin = [words(name)[:4] for name in (*(tab[0] for tab in TABS), "Keys")]
    assert len(set(begin)) == len(begin), "two tabs have similar names"


@pytest.mark.parametrize(
    ("language", "changes", "pairs", "said"),
    [
        ("en", 1, 1, "1 change among 1 pair."),
        ("en", 0, 102, "0 changes among 102 pairs."),
        ("de", 3, 2, "3 Wechsel bei 2 Paaren."),
        ("sl", 1, 1, "1 menjava med 1 parom."),
        ("sl", 2, 2, "2 menjavi med 2 paroma."),
        ("sl", 104, 3, "104 menjave med 3 pari."),
        ("sl", 5, 5, "5 menjav med 5 pari."),
        ("sl", 112, 12, "112 menjav med 12 pari."),
    ],
)
def test_a_number_chooses_its_plural_form(language: Language, changes: int, pairs: int, said: str) -> None:
    key = "{changes} {changes:change|changes} among {pairs} {pairs:pair|pairs}."
    assert words_of(language)(key, changes=changes, pairs=pairs) == said


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_welcome_promises_the_ring_only_as_long_as_possible(language: Language) -> None:
    words = words_of(language)
    bound = {"en": "as long as it can", "de": "solange er kann", "sl": "dokler more"}[language]
    # If only the orange arm avoids, the silver one does keep its hand in the ring.
    said = [
        words(key) for key in messages() if "hand in the ring" in key and not key.startswith("It keeps clear")
    ]
    # The welcome of a feature has such a text, too.
    assert len(said) >= 2 and all(bound in text for text in said)


def test_the_list_contains_texts_of_every_kind() -> None:
    found = set(messages())
    # A label, a hint, a choice; a literal; one by the name of a constant; a title; one of two; a row of buttons.
    assert {"your arm", "Which experiment.", "Hold pose", "paused", "avoidance first", "more plots"} <= found
    assert not found & (FORMULAS | NAMES)
    assert [length for length in LENGTHS if not length[0].isdigit() and length not in found] == []


def test_every_error_on_the_page_is_a_text_or_a_template() -> None:
    """An f-string cannot be looked up: give the template and its parts, `BadSetting("{key} is …", key=key)`."""
    errors = [(path.name, first) for path in on_the_page() for first in errors_of(path)]
    assert [
        f"{name}:{first.lineno}" for name, first in errors if isinstance(first, (ast.JoinedStr, ast.BinOp))
    ] == []
    assert {"settings.py", "run_file.py", "job_pool.py"} <= {path.name for path in on_the_page()}
    assert {
        "{key} = {value} is out of range; {remedy}",
        "processor",
        "The computation failed; the server's log says why.",
    } <= set(messages())


def test_names_of_bodies_and_joints_are_listed() -> None:
    set_language("pseudo")
    known = {word for body in (*BODIES, "silver", "orange") for word in re.split(r"[⟦⟧· ]+", pseudo(body))}
    for scene, robot in (("hold", "lwr"), ("ball", "ur5")):
        simulation = Simulation(changed(changed(RunSettings(), "scene", scene), "robot", robot))
        assert set(simulation.avoiding.labels) <= set(JOINTS)
        for pair in range(simulation.detector.count):
            assert set(re.split(r"[⟦⟧·()\d ]+", pair_name(simulation, pair))) <= known


def test_an_unknown_text_stays_english() -> None:
    words = Words("de", {"Law": "Gesetz", "{a} of {b}": "{a} von {c}"})
    assert (
        words("Law") == "Gesetz"
        and words("Never heard") == "Never heard"
        and words("Key: {key}", key="R") == "Key: R"
    )
    # A mistake in a file loses the translation, not the page.
    assert words("{a} of {b}", a=1, b=2) == "1 of 2"
    assert words_of("sl")("a moment\x04then") == "takrat"
    assert words_of("en")("a moment\x04then") == "then" and words_of("auto")("Law") == "Law"


@pytest.mark.parametrize("content", ['"a" = 3', '"a" = "b"\n"a" = "c"', "a b c", '[part]\n"a" = "b"'])
def test_a_broken_catalogue_is_refused(content: str, tmp_path: Path) -> None:
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
    assert tr("paused") == "paused" and (arm_colour("left", "right"), arm_colour("right", "right")) == (
        "silver",
        "orange",
    )
    set_language("de")
    assert (arm_colour("left", "right"), tr("paused")) == ("silbern", "angehalten")


@given(st.text("abc XYZ<>{}&;.1", max_size=60))
def test_pseudo_keeps_tags_and_parts(text: str) -> None:
    said = pseudo(text)
    assert parts(said) == parts(text) and pseudo(said) == said


def test_pseudo_is_longer_and_marked() -> None:
    assert pseudo("150") == "150" and pseudo("λ") == "λ"
    for text in (
        "Distance",
        "Reset {what} in <b>{d}</b> mm",
        "Smooth: half the time step, half the largest step.",
    ):
        shown = pseudo(text)
        assert shown.startswith(FIRST) and shown.endswith(LAST)
        assert len(shown) - len(text) >= round(GROWTH * len(re.sub(r"\{[^{}]*\}|<[^>]*>", "", text)))


@pytest.mark.parametrize(
    ("accept", "language"),
    [
        *(
            ("", "en"),
            ("de", "de"),
            ("de-AT", "de"),
            ("SL", "sl"),
            ("*", "en"),
            ("de;q=1.5", "en"),
            ("," * 5000, "en"),
        ),
        *(
            ("de-AT,de;q=0.9,en;q=0.8", "de"),
            ("fr, it", "en"),
            ("fr, sl;q=0.5, en;q=0.4", "sl"),
            ("en;q=0.3, de;q=0.7", "de"),
        ),
        *(("de;q=0, sl;q=0.1", "sl"), ("fr;q=1, *;q=0.5", "en"), ("sl ; q=0.7 , de; q=0.2", "sl")),
        ("de;q=nan, sl;q=two, ;;;,=,q", "en"),
    ],
)
def test_the_preferred_language_of_a_browser(accept: str, language: str) -> None:
    assert preferred(accept) == language
    # A choice by link or on the page has priority.
    assert (
        language_of(Settings(), preferred(accept)) == language
        and language_of(changed(Settings(), "lang", "de"), "sl") == "de"
    )


@given(st.text("desl-*q=;,.019 \t🦆", max_size=60))
def test_any_header_gives_a_language(accept: str) -> None:
    assert preferred(accept) in ("en", "de", "sl")
