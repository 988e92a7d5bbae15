"""The lever's data on the card: under which law, and on which page it can be moved."""

import html
import json
import re
from typing import Any

from app.features.lever import LEVER, STATIC
from app.web.headless_client import HeadlessClient
from tests.app.conftest import OpenHouse
from tests.app.served import is_whole
from tests.blocking_client import BlockingClient

WORDS = re.compile(r'class="duet-contact-words" data-text="([^"]*)"')


def lever_of(visitor: HeadlessClient | BlockingClient) -> dict[str, Any] | None:
    """The lever's data on a page's card; None without a lever."""
    contents = [str(one.get("content", "")) for one in list(visitor.mirror.gui.values())]
    words = [found[1] for found in map(WORDS.search, contents) if found is not None]
    return json.loads(html.unescape(words[0])).get("lever") if words else None


def test_the_card_has_the_lever_under_its_law_and_operates_it(house: OpenHouse) -> None:
    opened = house()
    with BlockingClient(opened.url, query="scene=hold&law=lever&lever=0.4&motion=paused") as visitor:
        visitor.wait_for(is_whole, 60.0)
        # The card appears before the box.
        visitor.wait_for(lambda page: (lever_of(page) or {}).get("box"), 60.0)
        told = lever_of(visitor)
        assert told is not None and told["value"] == 40 and told["box"] in visitor.mirror.gui
    with BlockingClient(opened.url, query="scene=hold&motion=paused") as visitor:
        visitor.wait_for(is_whole, 60.0)
        visitor.wait_for(
            lambda page: any(WORDS.search(str(one.get("content"))) for one in list(page.mirror.gui.values())),
            60.0,
        )
        assert lever_of(visitor) is None


def test_all_its_scripts_and_style_sheets_are_assets() -> None:
    assert LEVER.assets is not None
    assets = LEVER.assets()
    assert {*assets.scripts, *assets.styles} == {*STATIC.iterdir()}
