"""The container recipe, the systemd unit and the wheel: files exist, programs start, answer and end."""

import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
import urllib.request
import zipfile
from pathlib import Path
from typing import Final

import pytest
import tyro
from jupyter_client.kernelspec import KernelSpecManager
from jupyter_client.manager import KernelManager

from app.cli.serve import serve_with
from app.features import FEATURES
from app.runtime.terminal import TERMINATED
from app.web.origin_policy import check_origin
from tests.blocking_client import BlockingClient
from tests.test_imports import ROOT

pytestmark = pytest.mark.slow

RECIPE: Final = (ROOT / "app" / "deploy" / "Containerfile").read_text(encoding="utf-8")
UNIT: Final = ROOT / "app" / "deploy" / "duet.service"
PROGRAM: Final = "/opt/duet/bin/lwr-duet"
SAFE: Final = 2.5
"""Largest exposure (0 to 10): `systemd-analyze security` rates it OK by a good margin."""


def started_by(instruction: str) -> list[str]:
    """Arguments of the recipe's instruction that starts a program."""
    (found,) = re.findall(rf"{instruction} (\[.*\])$", RECIPE, flags=re.MULTILINE)
    return json.loads(found)


def in_this_place(arguments: list[str], folder: Path) -> list[str]:
    """The service's command with this environment's program, a free local port, and its own store."""
    program, *options = arguments
    assert program == PROGRAM and options[0] == "serve"
    store = options.index("--store") + 1
    assert options[store].endswith("/visitors.sqlite")
    options[store] = str(folder / "visitors.sqlite")
    return [sys.executable, "-m", "app", *options, "--host", "127.0.0.1", "--port", "0"]


def test_the_recipe_copies_existing_files_and_all_that_the_package_needs() -> None:
    copied = [line.split()[1:-1] for line in RECIPE.splitlines() if re.match("COPY (?!--from)", line)]
    names = {name for line in copied for name in line}
    assert [name for name in names if not (ROOT / name).exists()] == []
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    floors = re.findall(r'"(\w+)\*"', re.findall(r"^include = (.*)$", project, flags=re.MULTILINE)[0])
    # It is inside another package's folder.
    floors.remove("lwr_duet")
    assert len(floors) == 3 and names >= {*floors, "pyproject.toml", "README.md", "LICENSE"}
    (user,) = re.findall(r"^USER (\d+)$", RECIPE, flags=re.MULTILINE)
    assert f"useradd --uid {user} " in RECIPE


def test_the_base_image_is_fixed_by_its_digest() -> None:
    (base,) = re.findall(r"^ARG PYTHON=(\S+)$", RECIPE, flags=re.MULTILINE)
    assert re.fullmatch(r"3\.\d+\.\d+-slim-\w+@sha256:[0-9a-f]{64}", base)
    assert set(re.findall(r"^FROM (\S+)", RECIPE, flags=re.MULTILINE)) == {
        "docker.io/library/python:${PYTHON}"
    }


def test_the_container_installs_the_lock_with_hashes() -> None:
    assert "--require-hashes -r app/deploy/requirements.hashed" in RECIPE
    entries = (
        (ROOT / "app" / "deploy" / "requirements.hashed")
        .read_text(encoding="utf-8")
        .replace("\\\n", " ")
        .splitlines()
    )
    assert all(re.search(r" --hash=sha256:[0-9a-f]{64}", entry) for entry in entries)
    found = {entry.split()[0] for entry in entries}
    lock = {line.split()[0] for line in (ROOT / "requirements.lock").read_text(encoding="utf-8").splitlines()}
    assert {name for name in found if not name.startswith("setuptools==")} <= lock
    needed = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["dependencies"]
    names = {re.split(r"[=\[]", entry)[0] for entry in found}
    assert len(needed) > 15 and {re.split(r"[^\w.-]", one)[0].lower() for one in needed} <= names


@pytest.mark.thorough
def test_the_container_s_program_is_healthy_until_it_is_stopped(tmp_path: Path) -> None:
    python, *check = started_by("CMD")
    assert python == "/opt/duet/bin/python"
    with subprocess.Popen(
        in_this_place(started_by("ENTRYPOINT"), tmp_path), stdout=subprocess.PIPE, text=True
    ) as server:
        try:
            assert server.stdout is not None
            url = server.stdout.readline().split()[3]
            health = [sys.executable, *(part.replace("http://127.0.0.1:8080", url) for part in check)]
            assert health[1:] != check
            assert subprocess.run(health, timeout=60, check=False).returncode == 0
            server.terminate()
            assert server.wait(60) == TERMINATED
        finally:
            server.kill()
    assert subprocess.run(health, stderr=subprocess.DEVNULL, timeout=60, check=False).returncode == 1
    assert (tmp_path / "visitors.sqlite").is_file()


def test_the_unit_has_a_valid_command_and_accepts_its_exit_code(tmp_path: Path) -> None:
    settings = dict(
        line.split("=", 1)
        for line in UNIT.read_text(encoding="utf-8").splitlines()
        if re.match(r"\w+=", line)
    )
    serve = tyro.cli(serve_with(FEATURES), args=in_this_place(settings["ExecStart"].split(), tmp_path)[4:])
    for address in serve.allow_origin:
        check_origin(address)
    assert serve.allow_origin and not serve.open
    assert settings["SuccessExitStatus"] == str(TERMINATED) and settings["KillMode"] == "mixed"
    assert f"HOME=/var/lib/{settings['StateDirectory']}" == settings["Environment"]


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd is not installed")
def test_systemd_finds_no_mistake_in_the_unit_and_rates_it_as_hardened(tmp_path: Path) -> None:
    unit = tmp_path / UNIT.name
    # systemd also checks that the program exists.
    unit.write_text(UNIT.read_text(encoding="utf-8").replace(PROGRAM, sys.executable), encoding="utf-8")
    done = subprocess.run(
        ["systemd-analyze", "verify", unit], capture_output=True, text=True, timeout=60, check=False
    )
    # It may complain about other installed units.
    assert done.returncode == 0 and UNIT.name not in done.stderr, done.stderr
    judge = [
        "systemd-analyze",
        "security",
        "--offline=true",
        f"--threshold={round(10 * SAFE)}",
        "--no-pager",
        unit,
    ]
    done = subprocess.run(judge, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stdout[-80:]


UNPACKED = ("app/i18n/README.md", "app/biome.jsonc")
"""Files for developers, only in the repository."""

ENVIRONMENT = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")} | {
    "PYTHONIOENCODING": "utf-8"
}


def run(*command: str | Path, cwd: Path) -> str:
    """Output of a successful command."""
    done = subprocess.run(
        command, cwd=cwd, env=ENVIRONMENT, capture_output=True, text=True, timeout=200, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def files() -> list[str]:
    """Every file of a clean clone, and new files before their commit."""
    listed = run("git", "ls-files", "-z", "--cached", "--others", "--exclude-standard", cwd=ROOT).split("\0")
    return [file for file in listed if file and (ROOT / file).is_file()]


@pytest.fixture(scope="module")
def clone(files: list[str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    clone = tmp_path_factory.mktemp("clone")
    for file in files:
        (clone / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / file, clone / file)
    return clone


@pytest.fixture(scope="module")
def wheel(clone: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("wheel")
    run(sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", out, clone, cwd=out)
    (built,) = out.glob("lwr_duet-*.whl")
    return built


def environment_with(place: Path, *given: str | Path) -> Path:
    """Python of a new environment with the packages installed here, without this folder. `given`: for pip."""
    run(sys.executable, "-m", "venv", "--without-pip", place, cwd=place.parent)
    python = place / "bin" / "python"
    install = (sys.executable, "-m", "pip", "--python", python, "install", "-q", "--no-deps", "--no-compile")
    run(*install, *given, cwd=place.parent)
    (packages,) = place.glob("lib/python*/site-packages")
    installed = [path for path in sys.path if "site-packages" in path]
    (packages / "installed.pth").write_text("\n".join(installed) + "\n", encoding="utf-8")
    return python


@pytest.fixture(scope="module")
def command(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """`lwr-duet` of an environment with the wheel."""
    place = tmp_path_factory.mktemp("environment") / "venv"
    python = environment_with(place, "--no-index", wheel)
    where = run(python, "-c", "import app; print(app.__file__)", cwd=place.parent)
    assert Path(where.strip()).is_relative_to(place)
    return place / "bin" / "lwr-duet"


@pytest.fixture(scope="module")
def editable(clone: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """`lwr-duet` of an environment with an editable clone."""
    return environment_with(tmp_path_factory.mktemp("editable") / "venv", "-e", clone).with_name("lwr-duet")


@pytest.mark.thorough
def test_the_wheel_has_every_file_of_the_packages(files: list[str], wheel: Path) -> None:
    packed = set(zipfile.ZipFile(wheel).namelist())
    wanted = {
        file
        for file in files
        if file.startswith(("app/", "controllers/", "scenes/")) and file not in UNPACKED
    }
    wanted = {file.replace("app/lwr_duet/", "lwr_duet/") for file in wanted}
    assert "lwr_duet/__init__.py" in wanted
    assert len(wanted) > 200 and wanted - packed == set()


@pytest.mark.thorough
def test_the_wheel_serves_from_an_empty_folder_with_all_lessons(command: Path, tmp_path: Path) -> None:
    serve, said = [command, "serve", "--no-open", "--store", "memory", "--port", "0"], tmp_path / "said"
    with (
        said.open("w") as errors,
        subprocess.Popen(
            serve, cwd=tmp_path, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=errors, text=True
        ) as server,
    ):
        try:
            assert server.stdout is not None
            url = server.stdout.readline().split()[3]
            for path, content in (
                ("", b"duet-loading"),
                ("/documents/model?lang=de", b"<h1"),
                ("/healthz", b"true"),
            ):
                with urllib.request.urlopen(url + path, timeout=60) as answer:
                    assert answer.status == 200 and content in answer.read(), path
            with BlockingClient(url, query="lesson=1&lang=sl") as visitor:
                visitor.wait_for(
                    lambda v: "/arms/arm/base" in v.mirror.nodes and len(v.mirror.commands) >= 14
                )
        finally:
            server.terminate()
    assert "left out" not in said.read_text(encoding="utf-8")


IN_A_NOTEBOOK = """
from lwr_duet import RunSettings, duet, run
run(RunSettings(), seconds=0.05)
page = duet.show()
page.advance(0.5)
import app, controllers, scenes, threading
from app.version import duet_version
ended = threading.Event()
# In a process beside the kernel, which finds the same files.
job = page._app.context.jobs.submit("test", "version", duet_version, wake=ended.set)
while job.state in ("waiting", "running"):
    ended.wait(0.1)
print(app.__file__, controllers.__file__, scenes.__file__, page.history()["t"][-1] >= 0.5 and job.result == duet_version())
"""
"""First cell of a notebook in a folder with files of our packages' names."""


def in_a_kernel(python: Path, folder: Path, *cells: str) -> tuple[str, str]:
    """Output of the cells in a kernel started in a folder, and the last cell's error message."""
    spec = {
        "argv": [str(python), "-m", "ipykernel_launcher", "-f", "{connection_file}"],
        "display_name": "Duet",
        "language": "python",
    }
    specs = folder.parent / "kernels"
    (specs / "duet").mkdir(parents=True, exist_ok=True)
    (specs / "duet" / "kernel.json").write_text(json.dumps(spec), encoding="utf-8")
    manager = KernelManager(
        kernel_name="duet", kernel_spec_manager=KernelSpecManager(kernel_dirs=[str(specs)])
    )
    manager.start_kernel(
        cwd=str(folder), env=ENVIRONMENT | {"HOME": str(folder.parent), "IPYTHONDIR": str(folder.parent)}
    )
    client = manager.blocking_client()
    printed, error = [], ""
    try:
        client.start_channels()
        client.wait_for_ready(timeout=120)
        for cell in cells:
            hook = lambda message: (  # noqa: E731
                printed.append(message["content"]["text"]) if message["msg_type"] == "stream" else None
            )
            reply = client.execute_interactive(cell, timeout=120, output_hook=hook)["content"]
            error = reply.get("evalue", "")
    finally:
        client.stop_channels()
        manager.shutdown_kernel(now=True)
    return "".join(printed), error


@pytest.mark.thorough
@pytest.mark.parametrize("installed", ["command", "editable"])
def test_a_notebook_next_to_another_app_finds_duet(
    installed: str, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    python = request.getfixturevalue(installed).with_name("python")
    folder = tmp_path / "notebook"
    folder.mkdir()
    for name in ("app", "controllers", "scenes"):
        (folder / f"{name}.py").write_text(f"print('the folder: {name}')\n", encoding="utf-8")
    printed, error = in_a_kernel(python, folder, IN_A_NOTEBOOK)
    assert error == "" and "the folder" not in printed, printed + error
    files = printed.splitlines()[-1].split()
    assert files.pop() == "True" and [Path(file).name for file in files] == ["__init__.py"] * 3
    assert not any(Path(file).is_relative_to(folder) for file in files)
    # Too late: the message names the file with that name, and the remedy.
    printed, error = in_a_kernel(python, folder, "import app", IN_A_NOTEBOOK)
    assert "the folder: app" in printed
    assert f"'app', which this Python has given to {folder / 'app.py'}. Restart the kernel" in error


@pytest.mark.thorough
@pytest.mark.parametrize("installed", ["command", "editable"])
def test_the_command_finds_its_own_files_for_any_python_path(
    installed: str, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    """An empty entry of PYTHONPATH, for example by a trailing colon, is the current folder."""
    for name in ("app", "controllers", "scenes"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('the wrong file')\n", encoding="utf-8")
    program: Path = request.getfixturevalue(installed)
    for start in ([program], [program.with_name("python"), "-m", "lwr_duet"]):
        done = subprocess.run(
            [*start, "run", "--seconds", "0.05"],
            cwd=tmp_path,
            env=ENVIRONMENT | {"PYTHONPATH": os.pathsep.join(["", str(tmp_path)])},
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
        assert done.returncode == 0 and "d_min" in done.stdout, done.stdout + done.stderr
