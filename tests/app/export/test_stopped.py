"""A job ends as soon as its result is not wanted any more."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from app.export.csv_table import csv_bytes
from app.export.lab_report import Done, lab_bytes
from app.export.player import player_html
from app.export.plot_pictures import picture_bytes
from app.export.python_snippet import is_fresh
from app.export.scene_film import film_scene
from app.lessons.loading import load_lessons
from app.lessons.progress import StepProgress
from app.recording.replay import film
from app.recording.run_file import saved_bytes, saved_from, verify
from app.session.trade_off import row
from app.settings import PageSettings
from scenes.inputs import Recorded
from scenes.rerun import Stopped
from scenes.settings import RunSettings
from tests.app.export.runs import piece

Flag = Callable[[], bool]

JOBS: dict[str, Callable[[Recorded, Flag], object]] = {
    "table": lambda run, stopped: csv_bytes(run, 1.0, stopped=stopped),
    "picture": lambda run, stopped: picture_bytes(run, 1.0, "none", "png", stopped=stopped),
    "player": lambda run, stopped: player_html(run, 1.0, PageSettings(), stopped),
    "scene": lambda run, stopped: film_scene(run, 1.0, PageSettings(), stopped),
    "film": film,
    "run file": lambda run, stopped: saved_bytes(run, None, stopped),
    "verification": lambda run, stopped: verify(saved_from(saved_bytes(run), "a.npz"), stopped),
    "snippet": is_fresh,
    "report": lambda run, stopped: lab_bytes((Done(load_lessons().lessons[0], 0, StepProgress(), run),), "en", stopped),
    "map": lambda run, stopped: row(RunSettings(dt=0.02), 6.0, stopped),
}


@pytest.mark.parametrize("job", JOBS)
def test_a_job_stops(job: str) -> None:
    with pytest.raises(Stopped):
        JOBS[job](piece("hold", 1.0)[0], lambda: True)
