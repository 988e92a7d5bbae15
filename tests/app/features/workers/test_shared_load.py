"""Load of all processes together."""

import json
from urllib.request import urlopen

from app.features.workers.shared_load import LoadOfAll, combined
from app.page.panels.server_load import ServerLoad
from tests.app.conftest import OpenHouse

CALM, BUSY, NEW = ServerLoad(32, 5, 20, 40), ServerLoad(14, 28, 20, 140), ServerLoad(0, 0, 20, 0)


def test_the_combined_load_is_the_busiest_with_all_sessions() -> None:
    assert combined([CALM, BUSY]) == ServerLoad(14, 33, 40, 140)


def test_the_health_of_one_process_has_the_load_of_all(house: OpenHouse) -> None:
    opened = house()
    load = LoadOfAll(opened)
    opened.context.workload.report = NEW
    load.note([tuple(CALM), tuple(BUSY), tuple(NEW)])
    # A process that has drawn nothing yet is not the slowest.
    assert load.everywhere == combined([CALM, BUSY])
    load.note([tuple(NEW)])
    assert load.everywhere == ServerLoad(0, 0, 40, 0)
    load.note([tuple(CALM._replace(sessions=900))])
    with urlopen(f"{opened.url}/healthz", timeout=60.0) as answer:
        said = json.load(answer)
    assert said["ok"] and said["sessions"] >= 900 and not said["store"]["lasting"]
