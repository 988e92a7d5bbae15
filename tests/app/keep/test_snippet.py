"""Copied lines of Python: run, they make the run again."""

from __future__ import annotations

import io
import subprocess
import sys
from contextlib import redirect_stdout
from pathlib import Path

import pytest

from app.keep import snippet as snippet_module
from app.keep.run_file import saved_bytes
from app.keep.snippet import as_python, is_fresh, settings_python
from scenes.headless import Summary, run
from scenes.inputs import InputsLog, Recorded
from scenes.rerun import Stopped, rerun
from scenes.settings import LawSettings, RunSettings
from scenes.simulation import Simulation
from tests.app.keep.runs import piece
from tests.scenes.helpers import given_settings

ROOT = Path(__file__).parents[3]


def printed(text: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """What the lines print, in a folder."""
    assert len(text.splitlines()) <= 15
    monkeypatch.chdir(folder)
    out = io.StringIO()
    with redirect_stdout(out):
        exec(compile(text, "snippet", "exec"), {})
    return out.getvalue()


def test_the_lines_need_nothing_but_python(tmp_path: Path) -> None:
    recorded, _ = piece("ball", 1.0)
    code = f"import sys; sys.path.insert(0, {str(ROOT)!r})\n{as_python(recorded.settings, recorded)}"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(plain(run(recorded.settings, 1.0).summary))


def plain(summary: Summary) -> str:
    """A summary without the time that it took."""
    return repr(summary).rsplit(", step_us_median", 1)[0]


def test_settings_alone_make_the_run_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    recorded, _ = piece("ball", 1.0)
    text = as_python(recorded.settings, recorded)
    assert "base64" not in text and "scene='ball'" in text and "LawSettings" not in text
    assert printed(text, tmp_path, monkeypatch).startswith(plain(run(recorded.settings, 1.0).summary))


def test_nothing_recorded_is_a_fresh_run_of_the_settings() -> None:
    text = as_python(given_settings(n=8.0, k=3.0))
    assert "settings = RunSettings(gain=3.0, law=LawSettings(order=8.0))" in text
    assert "from scenes.settings import LawSettings, RunSettings" in text and "seconds=20.0" in text
    compile(text, "snippet", "exec")


def test_what_a_person_did_stands_in_the_text(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    recorded, _ = piece("hold", 2.0, 0.9, lively=True)
    text = as_python(recorded.settings, recorded)
    assert "b64decode" in text and "t = 1" in text
    assert printed(text, tmp_path, monkeypatch).startswith(plain(rerun(recorded).summary))


def test_too_much_for_a_text_is_read_from_the_saved_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(snippet_module, "MOST_CHARACTERS", 100)
    recorded, _ = piece("hold", 1.0, lively=True)
    text = as_python(recorded.settings, recorded, "mine.duet.npz")
    assert "Path('mine.duet.npz')" in text
    (tmp_path / "mine.duet.npz").write_bytes(saved_bytes(recorded))
    assert printed(text, tmp_path, monkeypatch).startswith(plain(rerun(recorded).summary))


def test_only_the_autopilot_from_a_fresh_start_is_fresh() -> None:
    recorded, _ = piece("hold", 1.0)
    assert is_fresh(recorded)
    assert not is_fresh(piece("hold", 2.0, 0.9)[0])  # not from the start
    assert not is_fresh(piece("hold", 1.0, lively=True)[0])  # other settings on the way
    assert not is_fresh(touched(at=150, start=None))  # somebody let go of everything
    simulation = Simulation(RunSettings())
    assert not is_fresh(touched(at=9999, start=simulation.room.start + 0.01))  # another posture
    with pytest.raises(Stopped):
        is_fresh(recorded, lambda: True)


def touched(at: int, start: object) -> Recorded:
    """A second of the autopilot from a posture, until nothing is wanted any more."""
    simulation, log = Simulation(RunSettings()), InputsLog()
    simulation.reset(start)  # pyright: ignore[reportArgumentType]
    person = simulation.person()
    for step in range(200):
        target = person.target(simulation.time) if step < at else None
        log.record(simulation, target)
        simulation.step(target)
    recorded = log.window(99.0)
    assert recorded is not None
    return recorded


def test_settings_as_python_are_the_settings() -> None:
    settings = given_settings(scene="imitation", dm=0.2, ff="1", seed=7, law="strict_switched", robot="panda")
    names = {"RunSettings": RunSettings, "LawSettings": LawSettings}
    assert eval(settings_python(settings), names) == settings
    assert settings_python(RunSettings()) == "RunSettings()"
