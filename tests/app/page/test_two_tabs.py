"""Two tabs of a real browser: apart by themselves, together in a lecture."""

from __future__ import annotations

import numpy as np
from playwright.sync_api import Dialog

from app.classroom.lecture import LectureHost
from app.settings import Settings
from scenes.settings import changed
from tests.app.conftest import HAND, OpenHouse, ask, live_sessions
from tests.app.page.by_hand import USUAL, WRIST, chosen, control, run_on, see_plots, set_by_hand, visit
from tests.browser import PageAt, until, wait_frames, wait_ready, world_position


def test_a_second_tab_is_private_and_a_link_sets_it(house: OpenHouse, page_at: PageAt) -> None:
    opened = house()
    one = page_at(900, 640)
    first = visit(one, opened, "autopilot=0")
    other = page_at(900, 640)
    alerts: list[str] = []

    def dismiss(dialog: Dialog) -> None:
        alerts.append(dialog.message)
        dialog.dismiss()

    other.on("dialog", dismiss)
    bad = "law=%3Cimg%20src%3Dx%20onerror%3Dalert(1)%3E"
    second = visit(other, opened, f"rig=table&dm=0.1&n=10&theme=dark&plot=lambda&{bad}")
    expected = {"rig": "table", "dm": 0.1, "n": 10.0, "theme": "dark", "plot": "lambda"}
    assert chosen(second) == USUAL | expected
    # What could not be done is named, as plain text.
    other.get_by_text("law = '<img src=x onerror=alert(1)>'").wait_for()
    assert other.locator("img[src=x]").count() == 0 and alerts == []
    other.wait_for_function("document.documentElement.dataset.mantineColorScheme === 'dark'")
    assert control(other, "dm").locator("input[type=text]").last.input_value() == "100"
    assert control(other, "n").locator("input[type=text]").last.input_value() == "10"
    see_plots(other, ("distance", "error", "activation λ"))
    # Neither sees the other.
    assert chosen(first) == USUAL | {"autopilot": False}
    assert one.evaluate("document.documentElement.dataset.mantineColorScheme") == "light"
    set_by_hand(one, first, "v")
    assert second.settings.run.law.nominal_velocity == 0.30
    assert not np.allclose(world_position(one, f"/arms/left{WRIST}"), world_position(other, f"/arms/left{WRIST}"), atol=0.05)
    other.close()
    until(one, lambda: len(live_sessions(opened)) == 1, "the session of the closed tab")
    run_on(one, first, 0.1)


def test_a_lecture_in_two_tabs(house: OpenHouse, page_at: PageAt) -> None:
    opened = house(changed(Settings(), "picture", "fast"), lecture=True)
    host = opened.host
    assert isinstance(host, LectureHost)
    session = host.session
    lecturer, listener = page_at(900, 640), page_at(900, 640)
    lecturer.goto(opened.url)
    wait_ready(lecturer, HAND)
    listener.goto(opened.url)
    wait_ready(listener, f"/arms/right{WRIST}")
    see_plots(listener, ("distance", "error"))
    listener.get_by_text("real time").wait_for()
    lecturer.mouse.click(520, 90)
    lecturer.keyboard.press(" ")
    until(lecturer, lambda: session.paused, "a pause")
    listener.get_by_text("paused", exact=True).wait_for()
    for side, joint in (("left", 7), ("right", 14)):
        place = ask(session, lambda s, joint=joint: s.simulation.kinematics.joint_point(joint).copy())
        for page in (lecturer, listener):
            until(page, lambda p=page, s=side, x=place: np.allclose(world_position(p, f"/arms/{s}{WRIST}"), x, atol=1e-3), side)
    assert lecturer.get_by_role("tab", name="Arms").count() == 1 and control(lecturer, "dm").count() == 1
    assert listener.get_by_role("tab", name="Arms").count() == 0 and control(listener, "dm").count() == 0
    assert listener.get_by_role("button", name="Pause").count() == 0
    assert not listener.evaluate(f"!!__viserMutable.nodeRefFromName['{HAND}']")
    # The listener's keys do nothing; the lecturer's do.
    steps = session.simulation.steps
    listener.mouse.click(520, 90)
    for key in (" ", "r", ".", "l", "1"):
        listener.keyboard.press(key)
        wait_frames(listener, 3)
    lecturer.keyboard.press("[")
    until(lecturer, lambda: session.settings.page.speed == 0.5, "slower")
    assert session.paused and session.simulation.steps == steps and session.settings.run == Settings().run
    # The lecturer comes back, and has the controls again; the listener never had them.
    number = host.operator
    lecturer.reload()
    until(lecturer, lambda: host.operator not in (None, number), "the lecturer again")
    wait_ready(lecturer, HAND)
    control(lecturer, "dm").wait_for()
    lecturer.mouse.click(520, 90)
    lecturer.keyboard.press(" ")
    until(lecturer, lambda: not session.paused, "going on")
    assert control(listener, "dm").count() == 0
