"""What is computed beside the frames: a queue that keeps its promises, and workers that come, go, and die without anybody noticing."""

from __future__ import annotations

import logging
import multiprocessing
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from app.runtime import job_pool as background_module
from app.runtime.job_pool import BUSY, ENDED, Job, JobPool
from tests.app.conftest import Join, OpenHouse, ask, live_sessions
from tests.app.jobs import die, double, note, refuse, stumble, wait_for, who

TIMEOUT = 60.0
"""Starting a process takes a while on a busy machine."""


def until(true: Callable[[], object], seconds: float = TIMEOUT) -> None:
    """Return as soon as something is true."""
    deadline, pause = time.monotonic() + seconds, threading.Event()
    while not true():
        assert time.monotonic() < deadline, "not in time"
        pause.wait(0.004)


def finished(*jobs: Job) -> bool:
    """Whether nothing more will happen to these jobs."""
    return all(job.state in ("done", "failed", "dropped") for job in jobs)


# --- the queue -----------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def shared() -> Iterator[JobPool]:
    """One worker for all tests that leave it alive."""
    background = JobPool(1)
    yield background
    background.close()


@pytest.fixture
def busy(shared: JobPool, tmp_path: Path) -> Iterator[Callable[[], None]]:
    """The only worker is busy until this is called."""
    until(lambda: shared.load == (0, 0))
    door = tmp_path / "door"
    job = shared.submit("somebody", "wait", wait_for, door)
    until(lambda: (tmp_path / "begun").exists())
    yield lambda: door.touch()
    door.touch()
    until(lambda: finished(job))


def test_a_job_is_done_and_wakes_who_waits(shared: JobPool) -> None:
    news = threading.Event()
    owner = object()
    job = shared.submit(owner, "a", double, 21.0, wake=news.set)
    assert news.wait(TIMEOUT)
    until(lambda: finished(job))
    assert (job.state, job.result, job.message, job.owner) == ("done", 42.0, "", owner)
    assert shared.load == (0, 0)


def test_a_worker_is_a_modest_one(shared: JobPool) -> None:
    job = shared.submit("me", "who", who)
    until(lambda: finished(job))
    number, patience, ignores, threads = job.result
    assert number != os.getpid() and ignores and threads == "1"
    assert patience == os.nice(0) + background_module.PATIENCE
    assert [child.pid for child in multiprocessing.active_children()] == [number]


@pytest.mark.usefixtures("busy")
def test_the_newest_request_replaces_the_older_ones(shared: JobPool, tmp_path: Path, busy: Callable[[], None]) -> None:
    words = tmp_path / "words"
    jobs = [shared.submit("me", "a", note, words, str(i)) for i in range(5)]
    other = shared.submit("me", "b", note, words, "other kind")
    another = shared.submit("you", "a", note, words, "other owner")
    assert [job.state for job in jobs] == ["dropped"] * 4 + ["waiting"]
    assert shared.load == (1, 3)
    busy()
    until(lambda: finished(*jobs, other, another))
    assert words.read_text().split("\n") == ["4", "other kind", "other owner", ""]


def test_whoever_asks_again_keeps_their_place(shared: JobPool, tmp_path: Path, busy: Callable[[], None]) -> None:
    words = tmp_path / "words"
    shared.submit("me", "a", note, words, "old")
    other = shared.submit("you", "a", note, words, "you")
    mine = shared.submit("me", "a", note, words, "me")
    busy()
    until(lambda: finished(mine, other))
    assert words.read_text().split() == ["me", "you"]


def test_a_running_job_is_stopped_by_a_newer_one(shared: JobPool, tmp_path: Path) -> None:
    old = shared.submit("me", "a", wait_for, tmp_path / "never")
    until(lambda: (tmp_path / "begun").exists())
    new = shared.submit("me", "a", double, 1.0)
    assert old.state == "dropped"
    until(lambda: finished(new))
    assert new.result == 2.0 and old.state == "dropped" and old.result is None


def test_an_owner_that_goes_takes_their_jobs_along(shared: JobPool, tmp_path: Path) -> None:
    owner, other = object(), object()
    running = shared.submit(owner, "a", wait_for, tmp_path / "never")
    until(lambda: (tmp_path / "begun").exists())
    waiting = [shared.submit(owner, kind, note, tmp_path / "words", kind) for kind in ("b", "c")]
    theirs = shared.submit(other, "b", double, 3.0)
    shared.cancel(owner, "b")
    assert [job.state for job in (running, *waiting)] == ["running", "dropped", "waiting"]
    shared.cancel(owner)
    assert [job.state for job in (running, *waiting)] == ["dropped"] * 3
    until(lambda: finished(theirs))
    assert theirs.result == 6.0 and not (tmp_path / "words").exists()
    until(lambda: shared.load == (0, 0))


def test_what_is_urgent_goes_first_and_the_others_begin_again(shared: JobPool, tmp_path: Path) -> None:
    patient = shared.submit("me", "long", wait_for, tmp_path / "door")
    until(lambda: (tmp_path / "begun").exists())
    words = tmp_path / "words"
    usual = shared.submit("me", "usual", note, words, "usual")
    urgent = shared.submit("you", "urgent", note, words, "urgent", urgent=True)
    until(lambda: finished(urgent))
    assert urgent.state == "done" and words.read_text().split()[0] == "urgent"
    (tmp_path / "door").write_text("at last")
    until(lambda: finished(patient, usual))
    assert patient.result == "at last" and len((tmp_path / "begun").read_text().split()) == 2
    assert words.read_text().split() == ["urgent", "usual"]


def test_what_is_urgent_does_not_drive_out_its_like(shared: JobPool, tmp_path: Path) -> None:
    first = shared.submit("me", "urgent", wait_for, tmp_path / "door", urgent=True)
    until(lambda: (tmp_path / "begun").exists())
    second = shared.submit("you", "urgent", double, 1.0, urgent=True)
    (tmp_path / "door").write_text("done")
    until(lambda: finished(first, second))
    assert first.result == "done" and second.result == 2.0
    assert (tmp_path / "begun").read_text().split() == ["door"]


def test_fifty_visitors_share_one_worker(shared: JobPool) -> None:
    owners = [object() for _ in range(50)]
    jobs = [shared.submit(owner, "what if", double, i, urgent=True) for i, owner in enumerate(owners) for _ in range(3)]
    assert len(multiprocessing.active_children()) == 1 and sum(shared.load) <= 51
    until(lambda: finished(*jobs))
    # What was asked for last is done of everybody; an earlier one may have been quicker than the next question.
    assert [(job.state, job.result) for job in jobs[2::3]] == [("done", 2.0 * i) for i in range(50)]
    assert len(multiprocessing.active_children()) == 1


@pytest.mark.usefixtures("busy")
def test_the_queue_is_bounded(shared: JobPool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(background_module, "MOST_WAITING", 3)
    owners = [object() for _ in range(5)]
    jobs = [shared.submit(owner, "a", double, 1.0) for owner in owners]
    assert [job.state for job in jobs] == ["waiting"] * 3 + ["failed"] * 2
    assert jobs[-1].message == BUSY
    # Asking again is always possible for whoever waits already.
    assert shared.submit(owners[2], "a", double, 2.0).state == "waiting"
    for owner in owners:
        shared.cancel(owner)


def test_what_a_person_can_put_right_is_told_to_them(shared: JobPool, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, "duet.background"):
        job = shared.submit("me", "a", refuse)
        until(lambda: finished(job))
        assert (job.state, job.message) == ("failed", "dm = 9 is out of range; give less.") and not caplog.records
        job = shared.submit("me", "a", stumble)
        until(lambda: finished(job))
    assert job.state == "failed" and "somewhere" not in job.message and "ZeroDivisionError" in caplog.text


def test_what_cannot_be_sent_fails_alone(shared: JobPool, caplog: pytest.LogCaptureFixture) -> None:
    job = shared.submit("me", "a", double, threading.Lock())
    until(lambda: finished(job))
    assert job.state == "failed"
    again = shared.submit("me", "a", double, 1.0)
    until(lambda: finished(again))
    assert again.result == 2.0


# --- the workers ---------------------------------------------------------------------------------------------------------------


def test_a_worker_that_dies_is_replaced(caplog: pytest.LogCaptureFixture) -> None:
    others = set(multiprocessing.active_children())
    background = JobPool(1)
    dying = background.submit("me", "die", die)
    after = [background.submit(i, "live", double, i) for i in range(3)]
    with caplog.at_level(logging.WARNING, "duet.background"):
        until(lambda: finished(dying, *after))
    assert (dying.state, dying.message) == ("failed", ENDED) and "ended from outside" in caplog.text
    assert [job.result for job in after] == [0.0, 2.0, 4.0]
    assert len(set(multiprocessing.active_children()) - others) == 1
    # Killed while it waits for work, when nobody looks.
    for child in set(multiprocessing.active_children()) - others:
        child.kill()
        child.join()
    late = background.submit("me", "live", double, 5.0)
    until(lambda: finished(late))
    if late.state == "failed":  # the pool had not noticed yet that its worker was gone
        late = background.submit("me", "live", double, 5.0)
        until(lambda: finished(late))
    assert late.result == 10.0
    background.close()


def test_closing_ends_everything_soon(tmp_path: Path) -> None:
    others = set(multiprocessing.active_children())
    background = JobPool(1)
    running = background.submit("me", "a", wait_for, tmp_path / "never")
    until(lambda: (tmp_path / "begun").exists())
    waiting = background.submit("me", "b", double, 1.0)
    (mine,) = set(multiprocessing.active_children()) - others
    background.close()
    assert not mine.is_alive() and (running.state, waiting.state) == ("dropped", "dropped")
    late = background.submit("me", "c", double, 1.0)
    assert late.state == "failed" and set(multiprocessing.active_children()) == others
    background.close()


def test_nothing_is_started_before_it_is_needed() -> None:
    before = set(multiprocessing.active_children())
    background = JobPool()
    assert 1 <= background.workers <= 4
    background.close()
    assert set(multiprocessing.active_children()) == before


PARENT = """
import sys, threading
from app.runtime.job_pool import Background
from tests.app.jobs import who
if __name__ == "__main__":
    background = Background(1)
    news = threading.Event()
    job = background.submit("me", "who", who, wake=news.set)
    news.wait()
    print(job.result[0], flush=True)
    sys.stdin.read()
"""


def alive(number: int) -> bool:
    """Whether there is such a process that is not merely waiting to be buried."""
    try:
        return Path(f"/proc/{number}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()[0] not in "ZX"
    except OSError:
        return False


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks at /proc")
def test_a_worker_does_not_outlive_a_killed_parent(tmp_path: Path) -> None:
    script = tmp_path / "parent.py"
    script.write_text(PARENT)
    root = Path(__file__).parents[2]
    environment = os.environ | {"PYTHONPATH": str(root)}
    with subprocess.Popen(
        [sys.executable, str(script)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment, cwd=root, text=True
    ) as parent:
        assert parent.stdout is not None
        worker = int(parent.stdout.readline())
        assert alive(worker)
        parent.kill()
    until(lambda: not alive(worker))


# --- in a house ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("lecture", [False, True])
def test_a_house_computes_for_its_visitors_and_ends_it_all(house: OpenHouse, join: Join, lecture: bool) -> None:
    opened = house(lecture=lecture)
    others = set(multiprocessing.active_children())
    visitor = join(opened)
    until(lambda: live_sessions(opened))
    (session,) = live_sessions(opened).values()

    def move(s: Any) -> None:
        s.change("whatif", True)
        for _ in range(40):
            s.advance(0.05)
        s.change("dm", 0.12)

    ask(session, move, TIMEOUT)
    visitor.wait_for(lambda _: session.what_if is not None and session.what_if.stride == 1, TIMEOUT)
    answer = session.what_if
    assert answer is not None and answer.settings.law.critical_distance == 0.12
    # Who asks and leaves leaves nothing behind.
    ask(session, lambda s: s.measure_smoothness())
    if not lecture:
        visitor.close()
        until(lambda: not live_sessions(opened))
        until(lambda: opened.context.jobs.load == (0, 0))
    opened.close()
    assert set(multiprocessing.active_children()) == others
    assert opened.context.jobs.load[1] == 0
