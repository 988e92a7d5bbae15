"""The wheel is complete: built from a clean copy and installed into a new environment, it serves from an empty folder."""

import os
import shutil
import subprocess
import sys
import urllib.request
import zipfile
from pathlib import Path

import pytest

from tests.blocking_client import BlockingClient
from tests.test_imports import ROOT

ENVIRONMENT = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")} | {"PYTHONIOENCODING": "utf-8"}


def run(*command: str | Path, cwd: Path) -> str:
    """The output of a command that succeeds."""
    done = subprocess.run(command, cwd=cwd, env=ENVIRONMENT, capture_output=True, text=True, timeout=200, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def files() -> list[str]:
    """Every file that a clean clone has, and those that are about to be committed."""
    listed = run("git", "ls-files", "-z", "--cached", "--others", "--exclude-standard", cwd=ROOT).split("\0")
    return [file for file in listed if file and (ROOT / file).is_file()]


@pytest.fixture(scope="module")
def wheel(files: list[str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    clone, out = tmp_path_factory.mktemp("clone"), tmp_path_factory.mktemp("wheel")
    for file in files:
        (clone / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / file, clone / file)
    run(sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", out, clone, cwd=out)
    (built,) = out.glob("lwr_duet-*.whl")
    return built


@pytest.fixture(scope="module")
def command(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """`lwr-duet` of a new environment, which sees the packages that are installed here, but not this folder."""
    place = tmp_path_factory.mktemp("environment") / "venv"
    run(sys.executable, "-m", "venv", "--without-pip", place, cwd=place.parent)
    python = place / "bin" / "python"
    run(sys.executable, "-m", "pip", "--python", python, "install", "-q", "--no-deps", "--no-index", wheel, cwd=place.parent)
    (packages,) = place.glob("lib/python*/site-packages")
    installed = [path for path in sys.path if "site-packages" in path]
    (packages / "installed.pth").write_text("\n".join(installed) + "\n", encoding="utf-8")
    where = run(python, "-c", "import app; print(app.__file__)", cwd=place.parent)
    assert Path(where.strip()).is_relative_to(packages)
    return place / "bin" / "lwr-duet"


def test_the_wheel_has_every_file_of_the_packages(files: list[str], wheel: Path) -> None:
    packed = set(zipfile.ZipFile(wheel).namelist())
    wanted = {file for file in files if file.startswith(("app/", "controllers/", "scenes/")) and file != "app/i18n/README.md"}
    assert len(wanted) > 200 and wanted - packed == set()


def test_the_lessons_and_their_pictures_can_be_read(command: Path, tmp_path: Path) -> None:
    assert [int(line.split()[0]) for line in run(command, "lessons", cwd=tmp_path).splitlines()] == list(range(1, 12))


def test_it_serves_from_an_empty_folder(command: Path, tmp_path: Path) -> None:
    serve = [command, "serve", "--no-open", "--store", "memory", "--port", "0"]
    with subprocess.Popen(serve, cwd=tmp_path, env=ENVIRONMENT, stdout=subprocess.PIPE, text=True) as server:
        try:
            assert server.stdout is not None
            url = server.stdout.readline().split()[3]
            for path, content in (("", b"duet-loading"), ("/documents/model?lang=de", b"<h1"), ("/healthz", b"true")):
                with urllib.request.urlopen(url + path, timeout=60) as answer:
                    assert answer.status == 200 and content in answer.read(), path
            with BlockingClient(url, query="lesson=1&lang=sl") as visitor:
                visitor.wait_for(lambda v: "/arms/arm/base" in v.mirror.nodes and len(v.mirror.commands) >= 14)
        finally:
            server.terminate()
