"""Background computations: the queue's rules, and replacement of dead workers."""

import logging
import multiprocessing
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

import pytest

from app.runtime import job_pool
from app.runtime.job_pool import BUSY, ENDED, Job, JobPool, Jobs
from tests.app.runtime.jobs import die, double, note, refuse, stumble, wait_for, who
from tests.app.runtime.processes import gone, until

pytestmark = pytest.mark.slow


def finish(*jobs: Job) -> None:
    until(lambda: all(job.state in ("done", "failed", "dropped") for job in jobs))


def load(pool: JobPool) -> tuple[int, int]:
    """Numbers of running and waiting jobs."""
    with pool._lock:
        return len(pool._running), len(pool._waiting)


def tell(path: Path, word: str) -> None:
    """Write the file that a job waits for, atomically."""
    draft = path.with_suffix(".draft")
    draft.write_text(word, encoding="utf-8")
    draft.replace(path)


def begun(folder: Path) -> None:
    until(lambda: (folder / "begun").exists())


@pytest.fixture(scope="module")
def others() -> set[BaseProcess]:
    """Processes of earlier tests."""
    return set(multiprocessing.active_children())


@pytest.fixture(scope="module")
def shared(others: set[BaseProcess]) -> Iterator[JobPool]:
    """Pool with one worker, for all tests that do not kill it."""
    background = JobPool(1)
    yield background
    background.close()


@pytest.fixture
def busy(shared: JobPool, tmp_path: Path) -> Iterator[Callable[[], None]]:
    """Function that frees the busy worker."""
    until(lambda: load(shared) == (0, 0))
    dispatcher = tmp_path / "dispatcher"
    job = shared.submit("other", "wait", wait_for, dispatcher)
    begun(tmp_path)
    yield lambda: dispatcher.touch()
    dispatcher.touch()
    finish(job)


def test_a_job_is_done_and_wakes_its_owner(others: set[BaseProcess], shared: JobPool) -> None:
    news = threading.Event()
    owner = object()
    job = shared.submit(owner, "a", double, 21.0, wake=news.set)
    assert news.wait(60.0)
    finish(job)
    assert (job.state, job.result, job.message, job.owner) == ("done", 42.0, "", owner)
    assert load(shared) == (0, 0)
    job = shared.submit("me", "who", who)
    finish(job)
    number, patience, ignores, threads = job.result
    assert number != os.getpid() and ignores and threads == "1"
    assert patience == os.nice(0) + job_pool.NICENESS
    assert [child.pid for child in set(multiprocessing.active_children()) - others] == [number]


def test_the_newest_request_replaces_older_ones(
    shared: JobPool, tmp_path: Path, busy: Callable[[], None]
) -> None:
    words = tmp_path / "words"
    jobs = [shared.submit("me", "a", note, words, "0")]
    jobs += [
        shared.submit("you", "a", note, words, "other owner"),
        shared.submit("me", "b", note, words, "other kind"),
    ]
    jobs += [shared.submit("me", "a", note, words, str(i)) for i in range(1, 5)]
    assert [job.state for job in jobs] == ["dropped", "waiting", "waiting", *["dropped"] * 3, "waiting"]
    assert load(shared) == (1, 3)
    busy()
    finish(*jobs)
    assert words.read_text().split("\n") == ["4", "other owner", "other kind", ""]


def test_a_leaving_owners_jobs_are_cancelled(shared: JobPool, tmp_path: Path) -> None:
    owner, other = object(), object()
    running = shared.submit(owner, "a", wait_for, tmp_path / "never")
    begun(tmp_path)
    waiting = [shared.submit(owner, kind, note, tmp_path / "words", kind) for kind in ("b", "c")]
    theirs = shared.submit(other, "b", double, 3.0)
    shared.cancel(owner, "b")
    assert [job.state for job in (running, *waiting)] == ["running", "dropped", "waiting"]
    shared.cancel(owner)
    assert [job.state for job in (running, *waiting)] == ["dropped"] * 3
    finish(theirs)
    assert theirs.result == 6.0 and not (tmp_path / "words").exists()
    until(lambda: load(shared) == (0, 0))


def test_an_urgent_job_goes_first_and_the_others_restart(shared: JobPool, tmp_path: Path) -> None:
    patient = shared.submit("me", "long", wait_for, tmp_path / "dispatcher")
    begun(tmp_path)
    words = tmp_path / "words"
    usual = shared.submit("me", "usual", note, words, "usual")
    urgent = shared.submit("you", "urgent", note, words, "urgent", urgent=True)
    finish(urgent)
    assert urgent.state == "done" and words.read_text().split()[0] == "urgent"
    tell(tmp_path / "dispatcher", "at last")
    finish(patient, usual)
    assert patient.result == "at last" and len((tmp_path / "begun").read_text().split()) == 2
    assert words.read_text().split() == ["urgent", "usual"]
    (tmp_path / "begun").unlink()
    first = shared.submit("me", "urgent", wait_for, tmp_path / "gate", urgent=True)
    begun(tmp_path)
    second = shared.submit("you", "urgent", double, 1.0, urgent=True)
    tell(tmp_path / "gate", "done")
    finish(first, second)
    assert (first.result, second.result) == ("done", 2.0) and (tmp_path / "begun").read_text().split() == [
        "gate"
    ]


@pytest.mark.usefixtures("busy")
def test_the_queue_is_bounded(shared: JobPool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(job_pool, "MOST_WAITING", 3)
    owners = [object() for _ in range(5)]
    jobs = [shared.submit(owner, "a", double, 1.0) for owner in owners]
    assert [job.state for job in jobs] == ["waiting"] * 3 + ["failed"] * 2
    assert jobs[-1].message == BUSY
    # A new request may always replace a waiting one.
    assert shared.submit(owners[2], "a", double, 2.0).state == "waiting"
    for owner in owners:
        shared.cancel(owner)


@pytest.mark.parametrize(
    ("function", "arguments", "logged"),
    [(refuse, (), ""), (stumble, (), "ZeroDivisionError"), (double, (threading.Lock(),), "pickle")],
    ids=["a visitor's mistake", "a mistake of ours", "arguments that cannot be sent"],
)
def test_a_failed_job_has_a_message_and_affects_no_other(
    shared: JobPool,
    caplog: pytest.LogCaptureFixture,
    function: Callable[..., Any],
    arguments: tuple[Any, ...],
    logged: str,
) -> None:
    message = (
        "The computation failed; the server's log says why."
        if logged
        else "dm = 9 is out of range; give less."
    )
    with caplog.at_level(logging.WARNING, "duet.background"):
        job, other = shared.submit("me", "a", function, *arguments), shared.submit("me", "b", double, 1.0)
        finish(job, other)
    assert (job.state, job.message, other.result) == ("failed", message, 2.0)
    assert bool(caplog.records) == bool(logged) and logged in caplog.text


@pytest.mark.thorough
def test_a_worker_that_dies_is_replaced(caplog: pytest.LogCaptureFixture) -> None:
    others = set(multiprocessing.active_children())
    background = JobPool(1)
    dying = background.submit("me", "die", die)
    after = [background.submit(i, "live", double, i) for i in range(3)]
    with caplog.at_level(logging.WARNING, "duet.background"):
        finish(dying, *after)
    assert (dying.state, dying.message) == ("failed", ENDED) and "ended from outside" in caplog.text
    assert [job.result for job in after] == [0.0, 2.0, 4.0]
    assert len(set(multiprocessing.active_children()) - others) == 1
    # Kill the worker while it waits for work.
    for child in set(multiprocessing.active_children()) - others:
        child.kill()
        child.join()
    late = background.submit("me", "live", double, 5.0)
    finish(late)
    if late.state == "failed":  # the pool had not noticed yet that its worker was gone
        late = background.submit("me", "live", double, 5.0)
        finish(late)
    assert late.result == 10.0
    background.close()


def test_closing_ends_jobs_and_workers_soon(tmp_path: Path) -> None:
    others = set(multiprocessing.active_children())
    assert 1 <= JobPool().workers <= 4
    background = JobPool(1)
    assert set(multiprocessing.active_children()) == others, "a worker was started too early"
    running = background.submit("me", "a", wait_for, tmp_path / "never")
    begun(tmp_path)
    waiting = background.submit("me", "b", double, 1.0)
    (mine,) = set(multiprocessing.active_children()) - others
    background.close()
    assert not mine.is_alive() and (running.state, waiting.state) == ("dropped", "dropped")
    late = background.submit("me", "c", double, 1.0)
    assert late.state == "failed" and set(multiprocessing.active_children()) == others
    background.close()


PARENT = """
import sys, threading
from app.runtime.job_pool import JobPool
from tests.app.runtime.jobs import who
if __name__ == "__main__":
    background = JobPool(1)
    news = threading.Event()
    job = background.submit("me", "who", who, wake=news.set)
    news.wait()
    print(job.result[0], flush=True)
    sys.stdin.read()
"""


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks at /proc")
def test_a_worker_does_not_outlive_a_killed_parent(tmp_path: Path) -> None:
    script = tmp_path / "parent.py"
    script.write_text(PARENT)
    root = Path(__file__).parents[3]
    environment = os.environ | {"PYTHONPATH": str(root)}
    with subprocess.Popen(
        [sys.executable, str(script)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=environment,
        cwd=root,
        text=True,
    ) as parent:
        assert parent.stdout is not None
        worker = int(parent.stdout.readline())
        assert not gone(worker)
        parent.kill()
    until(lambda: gone(worker))


def test_a_running_job_is_stopped_by_a_newer_one(shared: JobPool, tmp_path: Path) -> None:
    stop_by_a_newer_one(shared, tmp_path)


def stop_by_a_newer_one(jobs: Jobs, folder: Path) -> Job:
    """A running job after another one has replaced it."""
    old = jobs.submit("me", "a", wait_for, folder / "never")
    begun(folder)
    new = jobs.submit("me", "a", double, 4.0)
    assert old.state == "dropped"
    finish(new)
    assert new.result == 8.0 and old.state == "dropped" and old.result is None
    return old
