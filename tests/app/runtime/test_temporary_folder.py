"""A folder is removed with its process or at the next start; those of living processes and others stay."""

import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from app.runtime.temporary_folder import LOCK, TemporaryFolder, remove_abandoned

OWNER = """
import signal
from app.runtime.temporary_folder import TemporaryFolder
folder = TemporaryFolder("test")
(folder.path / "content").write_text("…", encoding="utf-8")
print(folder.path.parent, flush=True)
signal.pause()
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def owner(folder: Path) -> "tuple[subprocess.Popen[str], Path]":
    """A process, and its temporary folder."""
    command = [sys.executable, "-c", OWNER]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, text=True, env=os.environ | {"TMPDIR": str(folder)}
    )
    assert process.stdout is not None
    return process, Path(process.stdout.readline().strip())


def test_only_the_folder_of_a_killed_process_is_removed(here: Path) -> None:
    with TemporaryFolder("mine") as mine:
        killed, left = owner(here)
        living, kept = owner(here)
        try:
            killed.send_signal(signal.SIGKILL)
            killed.wait()
            # Folders of another program, and of a process that has no lock yet.
            others = [here / "duet-notes", here / "other-1"]
            for other in others:
                other.mkdir()
            (here / "other-1" / LOCK).touch()
            (here / "duet-link").symlink_to(here / "other-1")
            assert left.is_dir() and kept.is_dir()
            remove_abandoned()
            assert (
                not left.exists()
                and kept.is_dir()
                and (kept / "in" / "content").is_file()
                and mine.path.is_dir()
            )
            assert all(other.is_dir() for other in others) and (here / "other-1" / LOCK).exists()
        finally:
            living.terminate()
            living.wait()
            for process in (living, killed):
                assert process.stdout is not None
                process.stdout.close()
    assert not mine.path.parent.exists() and kept.is_dir(), "SIGTERM must leave the folder"
    remove_abandoned()
    assert not kept.exists()


def test_a_folder_is_removed_at_the_end_of_its_process(here: Path) -> None:
    code = OWNER.replace("signal.pause()", "")
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        env=os.environ | {"TMPDIR": str(here)},
        check=True,
    )
    assert Path(done.stdout.strip()).name.startswith("duet-test-") and list(here.iterdir()) == []
