"""The option for several processes: refusals, and equal settings of the app in one or several processes."""

import pickle
import socket
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from app.__main__ import run_command as main
from app.features.store.store_options import StoreOptions
from app.features.workers.worker_messages import WorkerStart
from app.features.workers.worker_options import WorkerOptions
from app.hosting.serve_options import ServeOptions
from app.runtime.progress import cores
from app.runtime.terminal import INTERRUPTED
from app.start import App
from tests.app.cli.test_commands import every_option, refused


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("--workers 0", "--workers must be at least 1."),
        (
            "--store memory --port 0 --workers 2 --camera 1",
            "--workers must be 1 here: one process reads the camera.",
        ),
    ],
)
def test_one_line_says_what_is_wrong(capsys: pytest.CaptureFixture[str], arguments: str, said: str) -> None:
    assert said in refused(capsys, "serve", *arguments.split())


def test_the_app_gets_all_options_in_one_process_and_in_several(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    served: list[ServeOptions] = []

    def alone(options: ServeOptions, *_: object, **__: object) -> App:
        served.append(options)
        raise KeyboardInterrupt

    def behind(_: socket.socket, start: WorkerStart, most: int) -> None:
        # Serialised as in the messages to a worker.
        alone(pickle.loads(pickle.dumps(start)).options)

    monkeypatch.setattr("app.start.start_app", alone)
    monkeypatch.setattr("app.features.workers.start.Dispatcher", behind)
    given = [
        "serve",
        *every_option(),
        "--law-file",
        str(tmp_path / "law-file"),
        "--store",
        str(tmp_path / "store"),
        "--keep",
        "2",
        "--store-size",
        "20",
    ]
    assert main([*given, "--workers", "1"]) == INTERRUPTED
    assert main([*given, "--workers", "2"]) == INTERRUPTED
    one, two = served
    store = StoreOptions(str(tmp_path / "store"), 2.0, 20.0, tmp_path / "store", locked=True)
    assert (one.of(StoreOptions), one.of(WorkerOptions)) == (store, WorkerOptions(1))
    assert (store.seconds, store.most_bytes) == (7200.0, 20_000_000)
    features = tuple(WorkerOptions(2) if isinstance(each, WorkerOptions) else each for each in one.features)
    assert two == replace(one, features=features, loops=min(2, cores()))


def test_the_listening_process_imports_no_heavy_library() -> None:
    heavy = "{'matplotlib', 'numba', 'numpy', 'pinocchio', 'viser', 'trimesh'}"
    code = f"import sys, app.features.workers.start; print(*sorted({heavy} & set(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True
    )
    assert (done.stdout.strip(), done.stderr) == ("", "")
