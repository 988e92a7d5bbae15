"""One pool of background jobs for several processes."""

import secrets
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.features.workers.job_address import JobAddress, start_job_server
from app.features.workers.shared_jobs import JobClient, JobServer
from app.runtime.job_pool import ENDED
from tests.app.runtime.jobs import double, note, refuse, stumble, wait_for
from tests.app.runtime.processes import until
from tests.app.runtime.test_job_pool import begun, finish, load, stop_by_a_newer_one
from tests.test_imports import ROOT

pytestmark = pytest.mark.slow


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
    failed = (
        one.submit("me", "a", refuse),
        one.submit("me", "b", stumble),
        one.submit("me", "c", double, lambda: None),
    )
    finish(*failed)
    assert [job.state for job in failed] == ["failed"] * 3 and all(job.message for job in failed)
    assert server.pool.workers == 1 and load(server.pool) == (0, 0)
    running = one.submit("me", "long", wait_for, tmp_path / "dispatcher")
    begun(tmp_path)
    waiting = other.submit("me", "b", note, tmp_path / "words", "other")
    urgent = other.submit("me", "urgent", double, 3.0, urgent=True)
    finish(urgent)
    assert urgent.result == 6.0 and waiting.state == "waiting"
    one.cancel("me")
    finish(waiting)
    assert running.state == "dropped" and (tmp_path / "words").read_text() == "other\n"


def test_a_running_job_is_stopped_by_a_newer_one(
    clients: tuple[JobClient, JobClient], tmp_path: Path
) -> None:
    stop_by_a_newer_one(clients[0], tmp_path)


def test_the_jobs_of_a_leaving_client_end(
    clients: tuple[JobClient, JobClient], server: JobServer, tmp_path: Path
) -> None:
    one, other = clients
    running = one.submit("me", "a", wait_for, tmp_path / "never")
    begun(tmp_path)
    one.close()
    left = other.submit("me", "a", double, 5.0)
    finish(left)
    assert (running.state, left.result) == ("dropped", 10.0)
    until(lambda: load(server.pool) == (0, 0))


@pytest.mark.thorough
def test_a_killed_server_is_restarted_by_the_next_job(
    address: JobAddress, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Its path lacks the current folder, and its job here is a function of the tests.
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    processes: list[subprocess.Popen[bytes]] = []

    def start() -> None:
        processes.append(start_job_server(address))

    client = JobClient(address, start)
    assert processes == []
    try:
        job = client.submit("me", "a", double, 1.0)
        finish(job)
        lost = client.submit("me", "a", wait_for, tmp_path / "never")
        begun(tmp_path)
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
