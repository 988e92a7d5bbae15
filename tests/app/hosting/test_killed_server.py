"""A server that is killed or terminated, and started again: its tabs go on where they were."""

import re

import numpy as np
import pytest

from app.hosting.visitor_record import VisitorRecord
from app.lessons.progress import Progress, from_json
from app.runtime.terminal import TERMINATED
from tests.app.page.helpers import buttons, click, hotkey_uuid
from tests.app.served import Serve, Served, kept
from tests.blocking_client import BlockingClient

EXPLORER, STUDENT = "e" * 32, "5" * 32
JOINT = re.compile(r"^/arms/.*/j[1-7]$")


def steps_of(record: VisitorRecord | None) -> int:
    return 0 if record is None or record.state is None else record.state.run.snapshot.steps


def progress_of(record: VisitorRecord | None) -> Progress:
    return from_json(record.lessons.progress if record is not None and record.lessons is not None else "")


def joints(visitor: BlockingClient) -> np.ndarray:
    """How the joints of both arms are turned, as quaternions."""
    nodes = visitor.mirror.nodes
    return np.array([nodes[name]["wxyz"] for name in sorted(nodes) if JOINT.search(name)])


def test_after_a_kill_a_tab_has_its_step_its_answer_and_its_arms(serve: Serve) -> None:
    served = serve("--workers", "2", "--sessions", "8")
    store = served.store
    exploring, learning = f"autopilot=0&resume={EXPLORER}", f"lesson=3&step=2&resume={STUDENT}"
    with served.come(exploring) as explorer, served.come(learning) as student:
        first = joints(explorer)
        for _ in range(4):
            explorer.send({"type": "CommandTriggerMessage", "uuid": hotkey_uuid(explorer, "up")})
        explorer.wait_for(lambda _: np.abs(joints(explorer) - first).max() > 0.02, 60.0)
        click(student, "2 ")
        student.wait_for(lambda v: "Run" in buttons(v), 60.0)
        student.wait_for(lambda _: any(done.choice == 1 for done in progress_of(kept(store, STUDENT)).steps.values()), 60.0)
        since = steps_of(kept(store, EXPLORER))
        # The hand has come to rest, and this is in the file.
        student.wait_for(lambda _: steps_of(kept(store, EXPLORER)) > since + 800, 60.0)
        moved, lesson = joints(explorer), progress_of(kept(store, STUDENT))
        (worker,) = served.workers
        served.replace(worker)

    def go_on(served: Served) -> None:
        begin = steps_of(kept(store, EXPLORER))
        with served.come(exploring) as explorer, served.come(learning) as student:
            explorer.wait_for(lambda _: steps_of(kept(store, EXPLORER)) > begin, 60.0)
            # The elbow still drifts a little; the hand was moved by more.
            assert np.abs(moved - first).max() > 5e-3
            explorer.wait_for(lambda _: np.abs(joints(explorer) - moved).max() < 5e-3, 60.0)
            student.wait_for(lambda v: "Run" in buttons(v), 60.0)
            assert progress_of(kept(store, STUDENT)) == lesson and [done.choice for done in lesson.steps.values()] == [1]
            served.kill()

    go_on(served)
    again = serve("--workers", "1", "--sessions", "8")
    go_on(again)


@pytest.mark.parametrize(("workers", "lecture"), [("1", False), ("2", True)])
def test_sigterm_writes_what_waits_and_a_lecture_goes_on(serve: Serve, workers: str, lecture: bool) -> None:
    served = serve("--workers", workers, *(["--lecture"] if lecture else []))
    with served.come(f"lesson=3&step=2&resume={STUDENT}") as visitor:
        if not lecture:
            click(visitor, "2 ")
            visitor.wait_for(lambda v: "Run" in buttons(v), 60.0)
        served.process.terminate()
        assert served.process.wait(60.0) == TERMINATED
    assert served.said() == ""
    record = kept(served.store, "lecture" if lecture else STUDENT)
    assert record is not None and record.lessons is not None and record.lessons.open
    assert [done.choice for done in progress_of(record).steps.values()] == ([] if lecture else [1])
