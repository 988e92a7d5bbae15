"""Copied lines of Python: run, they make the run again."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from app.export import python_snippet as snippet_module
from app.export.python_snippet import Snippet, as_python, is_fresh, settings_python
from controllers.kinematics import Array
from scenes.history import COLUMN
from scenes.inputs import KEEP, InputsLog, Recorded
from scenes.settings import LawSettings, RunSettings
from scenes.simulation import Simulation
from tests.app.export.runs import piece
from tests.scenes.helpers import given_settings

ROOT = Path(__file__).parents[3]


def executed(snippet: Snippet, folder: Path, name: str) -> tuple[str, Array]:
    """What the lines print, in a process of their own and a folder that holds nothing but what belongs to them, and their d."""
    if snippet.inputs is not None:
        (folder / f"{name}.duet.npz").write_bytes(snippet.inputs)
    (folder / "snippet.py").write_text(
        snippet.text + "import numpy\nnumpy.save('d.npy', table[:, COLUMN['d']])\n", encoding="utf-8"
    )
    environment, command = os.environ | {"PYTHONPATH": str(ROOT)}, [sys.executable, "snippet.py"]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    plot = (folder / f"{name}.png").read_bytes()
    assert plot.startswith(b"\x89PNG") and len(plot) > 10_000
    return done.stdout, np.load(folder / "d.npy")


@pytest.mark.parametrize("how", ["settings", "in the text", "in a file"])
def test_the_lines_make_the_chosen_piece_and_plot_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, how: str) -> None:
    if how == "in a file":
        monkeypatch.setattr(snippet_module, "MOST_CHARACTERS", 100)
    whole, table = piece("hold", 2.5, lively=how != "settings")
    recorded, _ = piece("hold", 2.5, 0.5, lively=how != "settings")
    assert recorded.seconds > 0.45
    snippet = as_python(whole, recorded, 0.4, "mine")
    assert len(snippet.text.splitlines()) <= 30 and (snippet.inputs is not None) == (how == "in a file")
    assert ("base64" in snippet.text) == (how == "in the text") and ("LawSettings" not in snippet.text or how != "settings")
    said, d = executed(snippet, tmp_path, "mine")
    steps = round(0.4 / recorded.stretches[-1].settings.dt)
    assert d.tobytes() == table[-steps:, COLUMN["d"]].tobytes()
    assert f"steps={steps}," in said and f"Summary(d_min={float(d.min())!r}," in said
    if how != "settings":
        assert f"from t = {table[-steps, COLUMN['t']]:.6g} s to 2.5" in snippet.text


def test_a_piece_has_the_settings_that_were_in_force(tmp_path: Path) -> None:
    whole, table = piece("hold", 2.5, lively=True)
    snippet = as_python(whole, whole, KEEP, "mine")
    _, d = executed(snippet, tmp_path, "mine")
    assert d.tobytes() == table[:, COLUMN["d"]].tobytes()


def test_an_arm_alone_is_plotted_without_a_distance(tmp_path: Path) -> None:
    recorded, _ = piece("solo", 0.5)
    snippet = as_python(recorded, recorded, 30.0, "alone")
    assert "d_m" not in snippet.text and "e²" in snippet.text
    executed(snippet, tmp_path, "alone")


def test_only_the_autopilot_from_a_fresh_start_is_fresh() -> None:
    recorded, _ = piece("hold", 1.0)
    assert is_fresh(recorded)
    assert not is_fresh(piece("hold", 2.0, 0.9)[0])  # not from the start
    assert not is_fresh(piece("hold", 1.0, lively=True)[0])  # other settings on the way
    assert not is_fresh(touched(at=150, start=None))  # all was let go of
    simulation = Simulation(RunSettings())
    assert not is_fresh(touched(at=9999, start=simulation.room.start + 0.01))  # another posture


def touched(at: int, start: object) -> Recorded:
    simulation, log = Simulation(RunSettings()), InputsLog()
    simulation.reset(start)  # pyright: ignore[reportArgumentType]
    person = simulation.source()
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
