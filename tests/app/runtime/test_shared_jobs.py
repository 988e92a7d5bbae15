"""One pool for several processes: every client has its own jobs, and a server that ends costs only the jobs that it had."""

import secrets
import subprocess
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from app.runtime.job_address import JobAddress, start_job_server
from app.runtime.job_pool import ENDED, Job
from app.runtime.shared_jobs import JobClient, JobServer
from tests.app.runtime.jobs import double, note, refuse, stumble, wait_for
from tests.app.runtime.processes import until

Begin = Callable[[], None]


def finish(*jobs: Job) -> None:
    until(lambda: all(job.state in ("done", "failed", "dropped") for job in jobs))


@pytest.fixture
def address(tmp_path: Path) -> JobAddress:
    return JobAddress(str(tmp_path / "jobs"), secrets.token_bytes(16))


@pytest.fixture
def server(address: JobAddress) -> Iterator[JobServer]:
    server = JobServer(address, 1)
    yield server
    server.close()


@pytest.fixture
def clients(address: JobAddress, server: JobServer) -> Iterator[tuple[JobClient, JobClient]]:
    both = JobClient(address, lambda: None), JobClient(address, lambda: None)
    yield both
    for client in both:
        client.close()


def test_two_clients_share_one_pool_and_each_gets_its_own_results(
    clients: tuple[JobClient, JobClient], server: JobServer, tmp_path: Path
) -> None:
    one, other = clients
    news = threading.Event()
    first, second = one.submit("me", "a", double, 1.0, wake=news.set), other.submit("me", "a", double, 2.0)
    finish(first, second)
    assert (first.result, second.result) == (2.0, 4.0) and news.wait(60.0)
    failed = one.submit("me", "a", refuse), one.submit("me", "b", stumble), one.submit("me", "c", double, lambda: None)
    finish(*failed)
    assert [job.state for job in failed] == ["failed"] * 3 and all(job.message for job in failed)
    assert server.pool.workers == 1 and server.pool.load == (0, 0)
    running = one.submit("me", "long", wait_for, tmp_path / "door")
    until(lambda: (tmp_path / "begun").exists())
    waiting = other.submit("me", "b", note, tmp_path / "words", "other")
    urgent = other.submit("me", "urgent", double, 3.0, urgent=True)
    finish(urgent)
    assert urgent.result == 6.0 and waiting.state == "waiting"
    one.cancel("me")
    finish(waiting)
    assert running.state == "dropped" and (tmp_path / "words").read_text() == "other\n"


def test_a_newer_request_replaces_an_older_one(clients: tuple[JobClient, JobClient], tmp_path: Path) -> None:
    client, _ = clients
    old = client.submit("me", "a", wait_for, tmp_path / "never")
    until(lambda: (tmp_path / "begun").exists())
    new = client.submit("me", "a", double, 4.0)
    finish(new)
    assert new.result == 8.0 and old.state == "dropped" and old.result is None


def test_a_client_that_goes_takes_its_jobs_along(clients: tuple[JobClient, JobClient], server: JobServer, tmp_path: Path) -> None:
    one, other = clients
    running = one.submit("me", "a", wait_for, tmp_path / "never")
    until(lambda: (tmp_path / "begun").exists())
    one.close()
    left = other.submit("me", "a", double, 5.0)
    finish(left)
    assert (running.state, left.result) == ("dropped", 10.0)
    until(lambda: server.pool.load == (0, 0))


def test_a_server_that_is_killed_is_started_again_with_the_next_job(address: JobAddress, tmp_path: Path) -> None:
    processes: list[subprocess.Popen[bytes]] = []

    def start() -> None:
        processes.append(start_job_server(address))

    client = JobClient(address, start)
    assert processes == []
    try:
        job = client.submit("me", "a", double, 1.0)
        finish(job)
        lost = client.submit("me", "a", wait_for, tmp_path / "never")
        until(lambda: (tmp_path / "begun").exists())
        processes[0].kill()
        finish(lost)
        assert (lost.state, lost.message) == ("failed", ENDED)
        again = client.submit("me", "a", double, 2.0)
        finish(again)
        assert (job.result, again.result, len(processes)) == (2.0, 4.0, 2)
    finally:
        client.close()
        for process in processes:
            process.kill()
            process.communicate()
