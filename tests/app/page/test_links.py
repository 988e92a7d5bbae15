"""What a link says is the start; what it says badly is named, and never more than text."""

import html
from urllib.parse import quote

from app.settings import Settings
from scenes.settings import values
from tests.app.conftest import Arrive, OpenHouse
from tests.app.page.helpers import notes

MALICE = "<img src=x onerror=alert(1)>"


def test_a_bad_part_of_a_link_is_named_as_plain_text_and_the_rest_holds(house: OpenHouse, arrive: Arrive) -> None:
    opened, bad = house(), quote(MALICE)
    one = arrive(opened, f"rig=table&dm=9&law={bad}&n=10&{bad}=1&v=nan&initialCameraFov=1&websocket=x&seed=1.5")
    assert values(one.session.settings) == values(Settings()) | {"rig": "table", "n": 10.0}
    one.visitor.wait_for(lambda _: len(notes(one.visitor)) >= 5)
    said = notes(one.visitor)
    for named in ("dm = '9'", f"law = '{MALICE}'", f"'{MALICE}'", "v = 'nan'", "seed = '1.5'"):
        assert sum(named in note for note in said) == 1 + (named == f"'{MALICE}'"), (named, said)
    # The browser shows a notification's text as text; nothing else may carry it.
    one.run_on(0.3)
    mirror = one.visitor.mirror
    others = [element for element in mirror.gui.values() if element["type"] != "NotificationShowMessage"]
    assert "onerror" not in repr((others, mirror.nodes, mirror.commands)) and html.escape(MALICE) not in repr(others)
    assert notes(arrive(opened, "rig=table&speed=0.5").visitor) == []
