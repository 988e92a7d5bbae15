"""A server that is killed or terminated, and started again: its tabs go on where they were."""

import os
import re
import signal
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from app.hosting.store_file import StoreFile
from app.hosting.visitor_record import VisitorRecord, record_from_bytes
from app.lessons.progress import Progress, from_json
from app.runtime.terminal import TERMINATED
from tests.app.page.helpers import buttons, click, hotkey_uuid
from tests.app.runtime.processes import until
from tests.app.served import Serve
from tests.blocking_client import BlockingClient

EXPLORER, STUDENT = "e" * 32, "5" * 32
JOINT = re.compile(r"^/arms/.*/j[1-7]$")

Kept = Callable[[str], VisitorRecord | None]


@pytest.fixture
def kept(tmp_path: Path) -> Kept:
    """`kept(tab)` is the record in the file of the running server."""

    def read(tab: str) -> VisitorRecord | None:
        file = StoreFile(tmp_path / "store", 10**9)
        found = file.read(tab)
        file.close()
        return None if found is None else record_from_bytes(found[1], VisitorRecord)

    return read


def steps_of(record: VisitorRecord | None) -> int:
    return 0 if record is None or record.state is None else record.state.run.snapshot.steps


def progress_of(record: VisitorRecord | None) -> Progress:
    return from_json(record.lessons.progress if record is not None and record.lessons is not None else "")


def joints(visitor: BlockingClient) -> np.ndarray:
    """How the joints of both arms are turned, as quaternions."""
    nodes = visitor.mirror.nodes
    return np.array([nodes[name]["wxyz"] for name in sorted(nodes) if JOINT.search(name)])


def come(url: str, query: str) -> BlockingClient:
    visitor = BlockingClient(url, query=query)
    visitor.wait_for(lambda v: len(v.mirror.commands) >= 14 and any(n.endswith("/j7") for n in list(v.mirror.nodes)), 60.0)
    return visitor


def test_after_a_kill_a_tab_has_its_step_its_answer_and_its_arms(serve: Serve, kept: Kept) -> None:
    served = serve("--workers", "2", "--sessions", "8")
    exploring, learning = f"autopilot=0&resume={EXPLORER}", f"lesson=3&step=2&resume={STUDENT}"
    with come(served.url, exploring) as explorer, come(served.url, learning) as student:
        first = joints(explorer)
        for _ in range(4):
            explorer.send({"type": "CommandTriggerMessage", "uuid": hotkey_uuid(explorer, "up")})
        explorer.wait_for(lambda _: np.abs(joints(explorer) - first).max() > 0.02, 60.0)
        click(student, "2 ")
        student.wait_for(lambda v: "Run" in buttons(v), 60.0)
        student.wait_for(lambda _: any(done.choice == 1 for done in progress_of(kept(STUDENT)).steps.values()), 60.0)
        since = steps_of(kept(EXPLORER))
        # The hand has come to rest, and this is in the file.
        student.wait_for(lambda _: steps_of(kept(EXPLORER)) > since + 800, 60.0)
        moved, lesson = joints(explorer), progress_of(kept(STUDENT))
        (worker,) = served.workers
        os.kill(worker, signal.SIGKILL)
        until(lambda: worker not in served.workers)

    def go_on(url: str, end: Callable[[], object]) -> None:
        begin = steps_of(kept(EXPLORER))
        with come(url, exploring) as explorer, come(url, learning) as student:
            explorer.wait_for(lambda _: steps_of(kept(EXPLORER)) > begin, 60.0)
            # The elbow still drifts a little; the hand was moved by more.
            assert np.abs(moved - first).max() > 5e-3
            explorer.wait_for(lambda _: np.abs(joints(explorer) - moved).max() < 5e-3, 60.0)
            student.wait_for(lambda v: "Run" in buttons(v), 60.0)
            assert progress_of(kept(STUDENT)) == lesson and [done.choice for done in lesson.steps.values()] == [1]
            end()

    go_on(served.url, served.kill)
    again = serve("--workers", "1", "--sessions", "8")
    go_on(again.url, again.kill)


@pytest.mark.parametrize(("workers", "lecture"), [("1", False), ("2", True)])
def test_sigterm_writes_what_waits_and_a_lecture_goes_on(serve: Serve, kept: Kept, workers: str, lecture: bool) -> None:
    served = serve("--workers", workers, *(["--lecture"] if lecture else []))
    with come(served.url, f"lesson=3&step=2&resume={STUDENT}") as visitor:
        if not lecture:
            click(visitor, "2 ")
            visitor.wait_for(lambda v: "Run" in buttons(v), 60.0)
        served.process.terminate()
        assert served.process.wait(60.0) == TERMINATED
    assert served.said() == ""
    record = kept("lecture" if lecture else STUDENT)
    assert record is not None and record.lessons is not None and record.lessons.open
    assert [done.choice for done in progress_of(record).steps.values()] == ([] if lecture else [1])
