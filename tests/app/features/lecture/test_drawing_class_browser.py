"""A class draws curves in real browsers: a cloud on the teacher's page, the median for all, the truth over it."""

import re

import pytest

from app.features.lessons.bookmark import Phase
from app.features.lessons.session.lesson_actions import Press
from app.settings import Settings
from scenes.settings import changed
from tests.app.conftest import OpenHouse, ask
from tests.app.features.lecture.lecture_room import lecture_of
from tests.app.features.lecture.test_browser import WAIT, come
from tests.app.features.lessons.test_drawing_browser import by_mouse
from tests.browser import PageAt, screenshot, until


@pytest.mark.thorough
def test_a_class_draws_a_cloud(house: OpenHouse, page_at: PageAt) -> None:
    opened = house(changed(Settings(), "picture", "fast"), lecture=True, key="chalk")
    host = lecture_of(opened)
    teacher, ann, bo = page_at(1000, 700), page_at(640, 600), page_at(640, 600)
    come(teacher, f"{opened.url}/?key=chalk&lesson=4&step=2")
    for page in (ann, bo):
        come(page, opened.url)
        page.locator(".duet-draw").wait_for()
    by_mouse(ann, (0.0, 0.9), (1.0, 0.3))
    by_mouse(bo, (0.0, 0.7), (1.0, 0.1))
    for page in (ann, bo):
        # The line for a reason appears beside the board, which keeps what is on it.
        page.get_by_label("Because …").wait_for()
        assert page.locator(".duet-draw .pencil").get_attribute("d")
        places = [
            found.bounding_box()
            for found in (page.locator(".duet-draw"), page.get_by_role("button", name=re.compile("^1 ")))
        ]
        assert places[0] and places[1] and places[0]["y"] < places[1]["y"], (
            "the board stands before the answers"
        )
    cloud = teacher.locator(".duet-poll")
    cloud.get_by_text("2 drawn").wait_for()
    cloud.get_by_text("2 answered (0 chose, 2 drew) · 0 not yet").wait_for()
    assert cloud.locator("path[stroke-opacity='0.3']").count() == 2 and ann.locator(".duet-poll").count() == 0
    teacher.get_by_role("button", name="Reveal to everybody").click()
    for page in (ann, bo):
        page.locator(".duet-poll").get_by_text("median").wait_for()
        page.locator(".duet-draw").wait_for(state="detached")
    for phase in (Phase.DO, Phase.OBSERVE):
        ask(host.session, lambda _: host.lessons.act(Press("next")))
        until(
            teacher,
            lambda phase=phase: ask(host.session, lambda _: host.lessons.walk.phase) is phase,
            phase.value,
            WAIT,
        )
    assert ask(host.session, lambda _: host.lessons.walk.done.drawing[0]) is not None, (
        "the stage's prediction is the class's"
    )
    for page in (teacher, ann):
        page.locator(".duet-poll").get_by_text("by the formula").first.wait_for()
        screenshot(page, f"drawing-class-{'teacher' if page is teacher else 'student'}")
    ann.locator(".duet-lesson:not(.duet-l-verdict) > .card").get_by_text("Your curve is off by 0.").wait_for()
    # Between two panels there is room for one plot, whose curves have their names on one line each.
    captions = teacher.locator("[data-duet-holds~=plots] [data-duet-holds~=caption]:visible")
    for width, shown in ((1000, ["distance", "Fig. 2: "]), (900, ["Fig. 2: "])):
        teacher.set_viewport_size({"width": width, "height": 700})
        until(
            teacher,
            lambda shown=shown: [text[:8] for text in captions.all_inner_texts()] == shown,
            f"{shown}",
            WAIT,
        )
    high = teacher.evaluate(
        "[...document.querySelectorAll('.duet-chart .name.faint')].map(name => name.offsetHeight)"
    )
    assert len(high) == 3 and max(high) < 16
    screenshot(teacher, "drawing-class-slim")
