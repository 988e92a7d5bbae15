"""A server is killed or terminated, then restarted: its tabs continue."""

import re

import numpy as np
import pytest

from app.hosting.visitor_record import VisitorRecord
from tests.app.features.lessons.helpers import opens_lesson, progress_in
from tests.app.features.store.kept import kept
from tests.app.features.workers.served import Serve
from tests.app.page.helpers import buttons, click, hotkey_uuid
from tests.blocking_client import BlockingClient

pytestmark = pytest.mark.thorough

EXPLORER, STUDENT, LATE = "e" * 32, "5" * 32, "6" * 32
JOINT = re.compile(r"^/arms/.*/j[1-7]$")


def steps_of(record: VisitorRecord | None) -> int:
    return 0 if record is None or record.state is None else record.state.run.snapshot.steps


def joints(visitor: BlockingClient) -> np.ndarray:
    """Rotations of both arms' joints as quaternions."""
    nodes = visitor.mirror.nodes
    return np.array([nodes[name]["wxyz"] for name in sorted(nodes) if JOINT.search(name)])


def answer(student: BlockingClient) -> None:
    click(student, "2 ")
    student.wait_for(lambda v: "Run" in buttons(v), 60.0)


def test_a_tab_has_its_step_answer_and_arms_after_a_kill_and_after_sigterm(
    serve: Serve,
) -> None:
    served = serve("--workers", "2", "--sessions", "8")
    store, lesson_link = served.store, "lesson=3&step=2&resume="
    exploring, learning = f"autopilot=0&speed=2&resume={EXPLORER}", lesson_link + STUDENT
    with served.come(exploring) as explorer, served.come(learning) as student:
        first = joints(explorer)
        for _ in range(4):
            explorer.send({"type": "CommandTriggerMessage", "uuid": hotkey_uuid(explorer, "up")})
        explorer.wait_for(lambda _: np.abs(joints(explorer) - first).max() > 0.02, 60.0)
        answer(student)
        student.wait_for(
            lambda _: any(done.choice == 1 for done in progress_in(kept(store, STUDENT)).steps.values()), 60.0
        )
        since = steps_of(kept(store, EXPLORER))
        # The hand has come to rest, and the file has this.
        student.wait_for(lambda _: steps_of(kept(store, EXPLORER)) > since + 800, 60.0)
        moved, lesson = joints(explorer), progress_in(kept(store, STUDENT))
        # The elbow still drifts a little; the hand has moved more.
        assert np.abs(moved - first).max() > 5e-3
        served.kill()
    begin = steps_of(kept(store, EXPLORER))
    served = serve("--workers", "1", "--sessions", "8")
    with served.come(exploring) as explorer, served.come(learning) as student:
        explorer.wait_for(lambda _: steps_of(kept(store, EXPLORER)) > begin, 60.0)
        explorer.wait_for(lambda _: np.abs(joints(explorer) - moved).max() < 5e-3, 60.0)
        student.wait_for(lambda v: "Run" in buttons(v), 60.0)
        assert progress_in(kept(store, STUDENT)) == lesson and [
            done.choice for done in lesson.steps.values()
        ] == [1]
    # An answer that is not yet written.
    with served.come(lesson_link + LATE) as late:
        answer(late)
        assert served.terminate() == ""
    record = kept(store, LATE)
    assert opens_lesson(record)
    assert [done.choice for done in progress_in(record).steps.values()] == [1]
