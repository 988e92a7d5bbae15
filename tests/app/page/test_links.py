"""What a link says is the start; what it says badly is named, and never more than text."""

import html
from urllib.parse import quote

import pytest

from app.settings import Settings
from scenes.settings import values
from tests.app.conftest import Arrive, OpenHouse
from tests.app.page.helpers import bodies, notes


def test_a_link_sets_the_start(house: OpenHouse, arrive: Arrive) -> None:
    opened = house()
    one = arrive(opened, "rig=table&law=unprotected&dm=0.1&n=10&theme=dark&plot=speeds&speed=0.5")
    expected = {"rig": "table", "law": "unprotected", "dm": 0.1, "n": 10.0, "theme": "dark", "plot": "speeds", "speed": 0.5}
    assert values(one.session.settings) == values(Settings()) | expected
    assert one.session.simulation.room.rig.name == "table"
    assert notes(one.visitor) == []
    # Controls and plots show it too; the last of them may still be on their way.
    mirror = one.visitor.mirror
    one.visitor.wait_for(lambda _: "colours" in {element.get("label") for element in list(mirror.gui.values())})
    assert mirror.labelled("d_m [mm]")["value"] == 100.0 and mirror.labelled("n")["value"] == 10.0
    assert mirror.labelled("law")["value"] == "Unprotected (task only)" and mirror.labelled("colours")["value"] == "Dark"
    one.visitor.wait_for(lambda _: len(bodies(one.visitor, "GuiUplotMessage")) == 3)
    plain = arrive(opened)
    assert plain.session.settings == Settings()


def test_a_bad_part_of_a_link_is_named_and_the_rest_holds(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house(), "rig=table&dm=9&law=strict&n=10&colour=red&v=nan&initialCameraFov=1&websocket=x&seed=1.5")
    assert values(one.session.settings) == values(Settings()) | {"rig": "table", "n": 10.0}
    one.visitor.wait_for(lambda _: len(notes(one.visitor)) >= 5)
    said = notes(one.visitor)
    for named in ("dm = '9'", "law = 'strict'", "'colour'", "v = 'nan'", "seed = '1.5'"):
        assert sum(named in note for note in said) == 1, (named, said)


MALICE = "<img src=x onerror=alert(1)>"


@pytest.mark.parametrize("query", [f"law={quote(MALICE)}", f"{quote(MALICE)}=1", f"seed={quote(MALICE)}"])
def test_a_links_text_is_only_ever_plain_text(house: OpenHouse, arrive: Arrive, query: str) -> None:
    one = arrive(house(), query)
    one.visitor.wait_for(lambda _: notes(one.visitor))
    # The browser shows a notification's text as text; nothing else may carry it.
    assert any(MALICE[:20] in note for note in notes(one.visitor))
    one.run_on(0.3)
    for element in list(one.visitor.mirror.gui.values()):
        if element["type"] != "NotificationShowMessage":
            assert "onerror" not in repr(element) and html.escape(MALICE) not in repr(element)
    assert "onerror" not in repr(one.visitor.mirror.nodes) and "onerror" not in repr(one.visitor.mirror.commands)
