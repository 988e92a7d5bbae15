"""Lesson cases of the core's `test_pages.py`."""

import pytest

from app.features.lessons.loading import load_lessons
from app.text.lesson_text import plain
from tests.app.conftest import Arrive, OpenHouse
from tests.app.i18n.test_pages import comes
from tests.app.page.helpers import bodies, notes, open_lessons
from tests.approved import Approve
from tests.blocking_client import BlockingClient


def labels(visitor: BlockingClient) -> list[str]:
    return [str(element["label"]) for element in list(visitor.mirror.gui.values()) if element.get("label")]


@pytest.mark.thorough
def test_bad_link_controls_and_change_of_language_on_a_slovene_page(
    house: OpenHouse, arrive: Arrive, approve: Approve
) -> None:
    guest = arrive(house(), "lang=sl&dm=9")
    visitor = guest.visitor
    visitor.wait_for(lambda _: notes(visitor))
    assert [note["title"] for note in bodies(visitor, "NotificationShowMessage")] == [
        "Del povezave je izpuščen"
    ]
    approve("link sl.txt", f"{notes(visitor)[0]}\n")
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
    own, others = (
        ("jezik", "prizor", "zakon", "ura"),
        {"language", "scene", "law", "clock", "Leave the lessons"},
    )
    visitor.wait_for(
        lambda _: (
            [labels(visitor).count(label) for label in own] == [1] * 4 and not others & set(labels(visitor))
        )
    )
