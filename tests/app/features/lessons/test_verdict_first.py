"""The page after a run: one sentence, one number, and the rest folded."""

import re
from html import unescape

import pytest

from app.features.lessons.bookmark import Phase
from app.features.lessons.panel.lesson_html import blocks_html
from app.features.lessons.panel.lesson_panel import ORDER, VERDICT
from app.features.lessons.step_view import first_sentence
from app.features.lessons.walkthrough import Walkthrough
from tests.app.features.lessons.helpers import our_book, run_out
from tests.approved import Approve, shown_text

BOOK = our_book()
NUMBERS = (("hand error", "0.11 mm"),)


def words(html: object) -> str:
    return unescape(re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", str(html))))


def test_after_a_run_the_verdict_has_one_sentence_and_one_number(approve: Approve) -> None:
    walk = Walkthrough(BOOK)
    walk.go("redundancy")
    walk.choose(1)
    before = blocks_html(walk.view(), NUMBERS, False, True)
    assert "Your prediction" in before["said"] and not before["verdict"] and "0.11" in before["live"]
    run_out(walk)
    assert walk.phase is Phase.OBSERVE
    after = blocks_html(walk.view(), NUMBERS, False, True)
    said = words(after["verdict"])
    approve("verdict.txt", shown_text(after["verdict"]))
    assert re.findall(r"\d+(?:\.\d+)?", said.partition("Measured")[2]) == ["4"], said
    assert not after["live"] and not after["said"], "the measured value is shown only once"
    assert after["after"].count("<details>") == 1 and "three axes" in after["after"]
    assert walk.step.title in after["head"] and first_sentence(walk.lesson.goal) not in after["head"]


def test_a_verdict_is_above_all_other_elements_of_the_panel() -> None:
    assert min(ORDER.values()) > VERDICT and VERDICT < 1.0, "the verdict is also above the button of the list"


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("One. Two.", "One."),
        ("At $a. b$ it is\nso. Then not.", "At $a. b$ it is so."),
        ("No end", "No end"),
        ("It is 0.5 here! Yes.", "It is 0.5 here!"),
    ],
)
def test_the_first_sentence_of_a_text(text: str, sentence: str) -> None:
    assert first_sentence(text) == sentence
