"""One worker among several: waiting tabs move to free workers, and messages from others are received."""

from pathlib import Path

import pytest

from app.features.store.store_options import StoreOptions
from app.features.workers.worker_host import WorkerHost
from app.features.workers.worker_messages import LetGo, MakeRoom, WorkerLink
from app.web.pages import ELSEWHERE
from app.web.server import MOVED_CODE
from tests.app.conftest import Made, private_of
from tests.app.web.conftest import ended


@pytest.mark.parametrize("lasting", [True, False])
def test_tabs_that_wait_for_their_pages_move_to_another_ready_worker(
    by_hand: Made, tmp_path: Path, lasting: bool
) -> None:
    sent: list[object] = []
    link = WorkerLink(0, sent.append)
    opened = by_hand(
        sessions=8,
        started_with=(link,),
        features=(StoreOptions(file=tmp_path / "store" if lasting else None),),
    )
    names = [f"resume={number:032d}" for number in range(6)]
    assert isinstance(opened.host, WorkerHost)
    first = opened.let_in(names[0])
    opened.let_in(names[5]).close()
    visitors = private_of(opened).visitors
    while len(visitors) > 1:
        opened.frame()
    newcomers = [opened.come(name) for name in names[1:]]
    link.put(MakeRoom(share=2))
    opened.frames()
    # The latest tabs move; a tab with a page stays. Without a file, the last tab's session exists only here.
    stays = 0 if lasting else 4
    moved = [place for place in range(5) if place != stays]
    for place in moved:
        assert ended(newcomers[place]) == (MOVED_CODE, ELSEWHERE)
    assert sent == [LetGo(names[1 + place].removeprefix("resume=")) for place in reversed(moved)]
    assert len(visitors) == 2 and first.closed is None and newcomers[stays].closed is None
