"""Waiting times for a run at the command line, and for the curves of "what if"."""

import subprocess
import time
from typing import Final

from app.features.bench.figures_table import BenchRows
from app.features.studies.background_studies import BackgroundStudies
from app.runtime.job_pool import JobPool
from app.session.session import Session
from app.settings import Settings
from controllers.own_packages import own_command
from scenes.experiments import HOLD
from scenes.settings import changed

PAST: Final = 30.0
"""Part of a run that "what if" simulates again [s]."""


def measure_waits() -> BenchRows:
    yield "run of 46 s", measure_run()
    yield "what if, 30 s again", measure_what_if()


def measure_run() -> dict[str, float]:
    """Time of `lwr-duet run` for 46 s of the hold experiment, and its start-up time [s]."""
    times: list[float] = []
    for seconds in ("46", "0.005"):
        begin = time.perf_counter()
        command = own_command("app.__main__", "run", "--scene", HOLD, "--seconds", seconds)
        subprocess.run(command, check=True, capture_output=True)
        times.append(time.perf_counter() - begin)
    return {"wall_s": times[0], "start_s": times[1]}


def measure_what_if() -> dict[str, float]:
    """Time from a slider's last move to the curves of "what if" [s]."""
    background = JobPool()
    session = Session(changed(Settings(), "whatif", True), background=background)
    try:
        while session.simulation.time < PAST:
            session.advance(0.05)
        figures: dict[str, float] = {}
        for name, distance in (("first_s", 0.12), ("later_s", 0.17)):
            answer = session.parts.of(BackgroundStudies).questions.what_if
            session.change("dm", distance)
            begin = time.perf_counter()
            while (
                session.parts.of(BackgroundStudies).questions.what_if is answer
                and time.perf_counter() - begin < PAST
            ):
                time.sleep(1.0 / 32.0)
                session.advance(1.0 / 32.0)
            figures[name] = time.perf_counter() - begin
        return figures
    finally:
        session.close()
        background.close()
