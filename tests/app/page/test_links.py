"""A link sets only its own tab; bad parts are reported as plain text."""

import html
from urllib.parse import quote

import numpy as np

from app.settings import Settings
from app.web.headless_client import HeadlessClient
from scenes.settings import values
from tests.app.conftest import Arrive, OpenHouse, live_sessions
from tests.app.page.by_hand import USUAL, WRIST, chosen, control, run_on, see_plots, set_by_hand, visit
from tests.app.page.helpers import notes
from tests.browser import PageAt, until, world_position


def test_a_second_tab_is_private_and_a_link_sets_it(house: OpenHouse, page_at: PageAt) -> None:
    opened = house()
    one = page_at(900, 640)
    first = visit(one, opened, "autopilot=0")
    other = page_at(900, 640)
    alerts: list[str] = []

    other.on("dialog", lambda dialog: alerts.append(dialog.message))
    other.on("dialog", lambda dialog: dialog.dismiss())
    bad = "law=%3Cimg%20src%3Dx%20onerror%3Dalert(1)%3E"
    second = visit(other, opened, f"rig=table&dm=0.1&n=10&theme=dark&plot=lambda&{bad}")
    expected = {"rig": "table", "dm": 0.1, "n": 10.0, "theme": "dark", "plot": "lambda"}
    assert chosen(second) == USUAL | expected
    # The bad part is reported as plain text.
    other.get_by_text("law = '<img src=x onerror=alert(1)>'").wait_for()
    assert other.locator("img[src=x]").count() == 0 and alerts == []
    other.wait_for_function("document.documentElement.dataset.mantineColorScheme === 'dark'")
    for key, number in {"dm": "100", "n": "10"}.items():
        box = control(other, key).locator("input[type=text]").last
        until(other, lambda box=box, number=number: box.input_value() == number, key)
    see_plots(other, ("distance", "error", "activation λ"))
    # The tabs do not affect each other.
    assert chosen(first) == USUAL | {"autopilot": False}
    assert one.evaluate("document.documentElement.dataset.mantineColorScheme") == "light"
    set_by_hand(one, first, "v")
    assert second.settings.run.law.nominal_velocity == 0.30
    assert not np.allclose(
        world_position(one, f"/arms/left{WRIST}"), world_position(other, f"/arms/left{WRIST}"), atol=0.05
    )
    other.close()
    until(one, lambda: len(live_sessions(opened)) == 1, "the session of the closed tab")
    run_on(one, first, 0.1)


MALICE = "<img src=x onerror=alert(1)>"


def test_a_bad_part_of_a_link_is_reported_as_text_and_the_rest_applies(
    house: OpenHouse, arrive: Arrive
) -> None:
    opened, bad = house(), quote(MALICE)
    one = arrive(
        opened, f"rig=table&dm=9&law={bad}&n=10&{bad}=1&v=nan&initialCameraFov=1&websocket=x&seed=1.5"
    )
    assert values(one.session.settings) == values(Settings()) | {"rig": "table", "n": 10.0}
    one.visitor.wait_for(lambda _: len(notes(one.visitor)) >= 5)
    said = notes(one.visitor)
    for named in ("dm = '9'", f"law = '{MALICE}'", f"'{MALICE}'", "v = 'nan'", "seed = '1.5'"):
        assert sum(named in note for note in said) == 1 + (named == f"'{MALICE}'"), (named, said)
    # The browser shows notifications as text; no other element may contain it.
    one.run_on(0.3)
    texts: list[str] = []

    def read(visitor: HeadlessClient) -> bool:
        mirror = visitor.mirror
        others = [element for element in mirror.gui.values() if element["type"] != "NotificationShowMessage"]
        texts[:] = repr((others, mirror.nodes, mirror.commands)), repr(others)
        return True

    # Read in the thread that changes them.
    one.visitor.wait_for(read)
    assert "onerror" not in texts[0] and html.escape(MALICE) not in texts[1]
    assert notes(arrive(opened, "rig=table&speed=0.5").visitor) == []
