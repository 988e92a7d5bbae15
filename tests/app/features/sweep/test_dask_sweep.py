"""`lwr-duet sweep --scheduler` on a real cluster: a scheduler and two workers, in separate processes here."""

import json
import os
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final
from uuid import uuid4

import pytest
import trimesh
from distributed import Client
from distributed.comm.core import CommClosedError

from app.__main__ import run_command as main
from app.features.robot_files.file_robot import register
from app.features.sweep import dask_cluster
from app.features.sweep.dask_cluster import environment, on_dask
from app.runtime.terminal import INTERRUPTED
from controllers.errors import BadInputFile, BadSetting, DuetError
from scenes.given_robots import given_at_start
from scenes.settings import RunSettings
from scenes.sweep import read_grid, run_points
from tests.app.features.robot_files.arm_urdf import arm_urdf
from tests.app.features.said import lines_of
from tests.app.runtime.processes import PATIENCE, until
from tests.approved import Approve

pytestmark = pytest.mark.thorough

HEARS: Final = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
ENTRY: Final = ("-c", HEARS + "from app.__main__ import entry; entry()", "sweep", "--no-maps")
DASK: Final = ("-m", "dask")
WITHOUT_DUET: Final = (
    "-c",
    "import sys\nfor name in ('app', 'scenes', 'controllers'): sys.modules[name] = None\nfrom dask.__main__ import main; main()",
)
LOCAL: Final = ("--host", "127.0.0.1", "--no-dashboard", "--dashboard-address", "127.0.0.1:0")
Process = subprocess.Popen[bytes]


@contextmanager
def process(folder: Path, *command: str, **more: str) -> Iterator[Process]:
    with (folder / "log").open("ab") as log:
        started = subprocess.Popen(
            [sys.executable, *command], cwd=folder, stdout=log, stderr=log, env=os.environ | more
        )
    try:
        yield started
    finally:
        started.kill()
        started.wait()


@contextmanager
def scheduler(folder: Path, program: tuple[str, ...] = DASK) -> Iterator[tuple[Process, str]]:
    """A scheduler on a free port, and its address."""
    file = folder / f"{uuid4()}.json"
    # A killed worker is given up after 10 s instead of half a minute.
    soon = {"DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "10s"}
    with process(
        folder, *program, "scheduler", *LOCAL, "--port", "0", "--scheduler-file", str(file), **soon
    ) as started:
        until(lambda: file.exists() and file.read_text(encoding="utf-8").endswith("}"), started)
        yield started, json.loads(file.read_text(encoding="utf-8"))["address"]


@contextmanager
def worker(folder: Path, address: str, program: tuple[str, ...] = DASK, **more: str) -> Iterator[Process]:
    """A worker that the scheduler counts as running, which takes a moment after its connection."""
    name = uuid4().hex
    options = (
        *LOCAL,
        "--no-nanny",
        "--nthreads",
        "2",
        "--local-directory",
        str(folder / "scratch"),
        "--name",
        name,
    )
    with process(folder, *program, "worker", address, *options, **more) as started:
        until(
            lambda: asked(
                address, lambda dask_scheduler: sum(one.name == name for one in dask_scheduler.running)
            ),
            started,
        )
        yield started


def asked(address: str, question: Callable[..., int]) -> Any:
    with Client(address, timeout=PATIENCE, set_as_default=False) as client:
        return client.run_on_scheduler(question)


def tasks(address: str) -> int:
    """Number of runs that the scheduler knows."""
    return asked(address, lambda dask_scheduler: len(dask_scheduler.tasks))


def rows(out: Path) -> int:
    part = out / "sweep.part.csv"
    text = part.read_text(encoding="utf-8") if part.exists() else ""
    return sum(line[:1].isdigit() for line in text.splitlines())


@contextmanager
def sweeping(out: Path, *arguments: str) -> Iterator[Process]:
    """A sweep that has written a few rows more than before."""
    command, before = [sys.executable, *ENTRY, *arguments, "--out", str(out)], rows(out)
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as sweep:
        try:
            until(lambda: rows(out) > before + 3, sweep)
            yield sweep
        finally:
            sweep.kill()


def test_a_sweep_outlives_ctrl_c_a_worker_and_the_scheduler(tmp_path: Path) -> None:
    grid, table, other = ("--over", "seed=1:60", "--seconds", "4"), tmp_path / "table", tmp_path / "other"
    with (
        scheduler(tmp_path) as (boss, address),
        worker(tmp_path, address),
        worker(tmp_path, address) as victim,
    ):
        with sweeping(table, *grid, "--scheduler", address) as sweep:
            sweep.send_signal(signal.SIGINT)
            _, said = sweep.communicate(timeout=PATIENCE)
        begun = rows(table)
        assert (sweep.returncode, said.decode().split(" are in")[0]) == (
            INTERRUPTED,
            f"{begun} of 60 runs",
        ), said
        until(lambda: tasks(address) == 0)
        with sweeping(table, *grid, "--scheduler", address) as sweep:
            victim.kill()
            assert begun < rows(table) < 60
            assert tasks(address) <= 20, "only a few for every thread, not the whole grid"
            out, said = sweep.communicate(timeout=PATIENCE)
        assert (sweep.returncode, out.decode().split()) == (0, [str(table / "sweep.csv")]), said
        with sweeping(other, *grid, "--scheduler", address) as sweep:
            boss.kill()
            _, said = sweep.communicate(timeout=PATIENCE)
        assert (sweep.returncode, said.count(b"\n")) == (2, 1) and b"The scheduler is gone" in said, said
        assert 3 < rows(other) < 60
    # The rest runs here, without another process.
    assert main(["sweep", "--no-maps", *grid, "--workers", "1", "--out", str(other)]) == 0
    assert (table / "sweep.csv").read_bytes() == (other / "sweep.csv").read_bytes()


def refusal(address: str) -> str:
    """The error of a sweep that does not start on a cluster."""
    with pytest.raises(BadSetting) as error, on_dask(address):
        pass
    return str(error.value)


@pytest.mark.parametrize("place", ["while it is asked", "while a result is fetched"])
def test_a_scheduler_that_ends_at_any_moment_is_named(monkeypatch: pytest.MonkeyPatch, place: str) -> None:
    def gone(*_: object) -> None:
        raise CommClosedError("in <TCP (closed)>: ConnectionResetError: [Errno 104] Connection reset by peer")

    closed: list[bool] = []
    monkeypatch.setattr(
        dask_cluster, "_connected", lambda _: SimpleNamespace(close=lambda: closed.append(True))
    )
    monkeypatch.setattr(dask_cluster, "_check", gone if place == "while it is asked" else lambda *_: None)
    with pytest.raises(DuetError, match="The scheduler is gone"), on_dask("tcp://127.0.0.1:1"):
        gone()
    assert closed == [True]


def test_computers_with_another_duet_or_without_it_are_named(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, approve: Approve
) -> None:
    """On that worker's path, the metadata of another version come first, as of an installed package."""
    monkeypatch.setattr(dask_cluster, "JOINING", 0.2)
    metadata, grid = tmp_path / "other" / "lwr_duet.dist-info", read_grid(RunSettings(), ["seed=1:2000"], 0.5)
    metadata.mkdir(parents=True)
    (metadata / "METADATA").write_text(
        "Metadata-Version: 2.1\nName: lwr-duet\nVersion: 9.9.9\n", encoding="utf-8"
    )
    with scheduler(tmp_path, WITHOUT_DUET) as (_, address):
        assert f"scheduler {address} has no Duet" in refusal(address)
    with scheduler(tmp_path) as (_, address):
        approve("refusal without workers.txt", refusal(address).replace(address, "ADDRESS") + "\n")
        with worker(tmp_path, address):
            with on_dask(address) as compute:
                found = run_points(grid, range(grid.size), compute)
                next(found)
                with worker(tmp_path, address, PYTHONPATH=str(metadata.parent)):
                    said = refusal(address)
                    with pytest.raises(BadSetting, match=r"joined has Duet 9\.9\.9"):
                        list(found)
            assert re.match(r"The worker tcp://127.* has Duet 9.9.9 ", said)
            with worker(tmp_path, address, WITHOUT_DUET):
                assert re.match(r"The worker tcp://127.* has no Duet", refusal(address))


def test_a_library_of_another_version_is_named(approve: Approve) -> None:
    here = environment()
    with pytest.raises(BadSetting) as error:
        dask_cluster.compare("worker W", here, here | {"coal": "0.0"})
    approve("refusal of another version.txt", f"{error.value}\n".replace(here["coal"], "VERSION"))


def test_a_worker_with_other_meshes_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, registry: None
) -> None:
    path, mesh = tmp_path / "box.urdf", tmp_path / "box.stl"
    trimesh.creation.box((0.1, 0.1, 0.2)).export(mesh)
    path.write_text(arm_urdf(shape='<mesh filename="box.stl"/>'), encoding="utf-8")
    register(path)
    monkeypatch.setattr(dask_cluster, "checked", set())
    asked = environment(), given_at_start(), abs, (-3,)
    assert dask_cluster.called_there(*asked) == 3
    mesh.write_bytes(mesh.read_bytes() + b" ")
    # Checked only once.
    assert dask_cluster.called_there(*asked) == 3
    dask_cluster.checked.clear()
    with pytest.raises(BadInputFile, match=r"box\.urdf: is another"):
        dask_cluster.called_there(*asked)


def test_an_address_without_a_scheduler_is_named_soon(
    monkeypatch: pytest.MonkeyPatch, approve: Approve
) -> None:
    monkeypatch.setattr(dask_cluster, "CONNECTING", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        busy = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        said = {"silent": refusal(busy).replace(busy, "ADDRESS")}
    said["closed"] = refusal(busy).replace(busy, "ADDRESS")
    for address in ("127.0.0.1:1", "host:8786/x", "nothing", "", "http://127.0.0.1:1"):
        said[f"“{address}”"] = refusal(address)
    # Dask's own text differs by version.
    approve("refusals of addresses.txt", re.sub(r"\(.*?\);", "(…);", lines_of(said)))


def test_a_missing_dask_and_workers_of_both_kinds_are_named(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str], approve: Approve
) -> None:
    base = ["sweep", "--over", "n=1:2", "--out", str(tmp_path / "out"), "--scheduler", "tcp://127.0.0.1:1"]
    assert main([*base, "--workers", "2"]) == 2
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert main(base) == 2
    approve("refusals on a cluster.txt", capsys.readouterr().err)
