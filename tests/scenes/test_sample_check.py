"""Samples that do not fit the run are refused or cause one warning with column, size and likely unit."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.__main__ import run_command as main
from controllers.errors import BadInputFile
from controllers.kinematics import Array
from scenes.recording import Recording, inputs_from
from scenes.sample_check import check_samples
from scenes.settings import RunSettings
from scenes.simulation import Simulation
from tests.scenes.helpers import given_settings

TABLE = RunSettings(rig="table")
COUNT = 60
T: Array = 0.05 * np.arange(COUNT, dtype=np.float64)


def near_the_hand(settings: RunSettings = TABLE) -> Array:
    """Places (COUNT, 3) of a hand that moves at 0.1 m/s from its start."""
    simulation = Simulation(settings, 1)
    place = simulation.kinematics.hand_pose(simulation.guided).translation
    return place - np.array([0.0, 0.0, 0.2]) * T[:, None] * 0.5


PLACES = near_the_hand()
EPOCH = 1_764_275_000.0

REFUSED: dict[str, tuple[Array, Array, tuple[str, ...]]] = {
    "stamps of ROS": (T + EPOCH, PLACES, ("t begins at 1764275000", "seconds since 1970", "subtract")),
    "stamps of ROS in milliseconds": (
        (T + EPOCH) * 1e3,
        PLACES,
        ("t begins at 1764275000000", "milliseconds", "by 1000"),
    ),
    "stamps of ROS in microseconds": ((T + EPOCH) * 1e6, PLACES, ("microseconds", "by 1000000")),
    "stamps of ROS in nanoseconds": (
        (T + EPOCH) * 1e9,
        PLACES,
        ("t begins at 1.764275e+18", "nanoseconds", "by 1000000000"),
    ),
    "nanoseconds": (T * 1e9, PLACES, ("t goes from 0 to 2950000000", "nanoseconds", "by 1000000000")),
    "after the run": (
        T + 100.0,
        PLACES,
        ("t begins at 100 s", "run of 3 s", "subtract", "--seconds above 102.95"),
    ),
    "milliseconds after the run": ((T + 5.0) * 1e3, PLACES, ("t begins at 5000", "milliseconds", "by 1000")),
    "before the run": (T - 100.0, PLACES, ("t ends at -97.05", "subtract")),
}


@pytest.mark.parametrize("case", REFUSED)
def test_samples_outside_the_run_are_refused(case: str) -> None:
    times, places, words = REFUSED[case]
    with pytest.raises(BadInputFile) as caught:
        check_samples(Recording(times, places), TABLE, 3.0, "a.csv")
    message = str(caught.value)
    assert message.startswith("a.csv: ") and "\n" not in message
    assert [word for word in words if word not in message] == [], message


DOUBTED: dict[str, tuple[Array, Array, float, tuple[str, ...]]] = {
    "milliseconds": (T * 1e3, PLACES, 3.0, ("t grows by 50 s", "mm/s", "milliseconds", "by 1000.")),
    "milliseconds of a fast sensor": (T * 20.0, PLACES, 30.0, ("t grows by 1 s", "milliseconds")),
    "microseconds": (T * 1e6, PLACES, 3.0, ("t grows by 50000 s", "microseconds", "by 1000000.")),
    "late": (T + 43.0, PLACES, 46.0, ("t goes from 43 to 45.95 s", "0 to 46 s", "60 of 60", "--seconds")),
    "short": (T * 0.1, PLACES, 46.0, ("t goes from 0 to 0.295 s", "hardly overlap")),
    "almost before": (T - 2.9, PLACES, 46.0, ("t goes from -2.9", "hardly overlap", "2 of 60")),
    "long steps": (
        60.0 * np.arange(6, dtype=np.float64),
        PLACES[0] + np.outer(np.arange(6) % 2, (0.0, 0.0, -0.5)),
        46.0,
        ("1 of 6",),
    ),
    "decimetres": (T, PLACES * 10.0, 3.0, ("x, y and z", "shoulder", "reaches", "metres")),
    "another frame": (T, PLACES + np.array([4.0, 3.0, 0.0]), 3.0, ("x, y and z", "shoulder")),
}


@pytest.mark.parametrize("case", DOUBTED)
def test_unlikely_samples_cause_one_warning(case: str) -> None:
    times, places, seconds, words = DOUBTED[case]
    (said,) = check_samples(Recording(times, places), TABLE, seconds, "a.csv")
    assert said.startswith("a.csv: ") and "\n" not in said
    assert [word for word in words if word not in said] == [], said


FAR_APART = PLACES[0] + np.array(
    [[0.0, 0.0, 0.0], [0.0, 0.0, -0.1], [0.0, 0.0, 0.0], [0.0, 0.0, 0.1], [0.0, 0.0, 0.0]]
)

FINE: dict[str, tuple[Array, Array, float]] = {
    "as long as the run": (T, PLACES, 3.0),
    "cut by the run": (T, PLACES, 1.0),
    "a fifth of the run": (T, PLACES, 15.0),
    "begun before the run": (T - 1.0, PLACES, 3.0),
    "one place": (T[:1], PLACES[:1], 46.0),
    "a few ways": (2.0 * np.arange(5, dtype=np.float64), FAR_APART, 10.0),
    "a hand at rest": (np.arange(COUNT, dtype=np.float64), np.tile(PLACES[0], (COUNT, 1)), 46.0),
    "a hand that goes away and comes back": (T, PLACES + np.linspace(0.0, 3.0, COUNT)[:, None], 3.0),
    "dense": (T * 0.02 + 0.1, PLACES, 0.5),
}


@pytest.mark.parametrize("case", FINE)
def test_good_samples_cause_no_warning(case: str) -> None:
    times, places, seconds = FINE[case]
    assert check_samples(Recording(times, places), TABLE, seconds, "a.csv") == ()


@given(
    st.sampled_from((1.0, 1e3, 1e6, 1e9)), st.floats(1e9, 2e9), st.floats(0.001, 0.2), st.floats(0.1, 1000.0)
)
def test_clock_times_since_1970_are_always_refused(
    per: float, begin: float, step: float, seconds: float
) -> None:
    times: Array = np.unique((begin + step * np.arange(COUNT, dtype=np.float64)) * per)
    with pytest.raises(BadInputFile, match="since 1970"):
        check_samples(Recording(times, np.tile(PLACES[0], (len(times), 1))), TABLE, seconds, "a.csv")


@given(st.sampled_from((1e3, 1e6, 1e9)), st.floats(0.001, 0.1), st.floats(0.1, 1.0), st.floats(0.5, 60.0))
def test_another_unit_of_time_is_always_reported(
    per: float, step: float, speed: float, seconds: float
) -> None:
    times: Array = step * np.arange(COUNT, dtype=np.float64)
    places = PLACES[0] + 0.1 * np.sin(speed / 0.1 * times)[:, None] * np.array([0.0, 0.0, 1.0])
    try:
        said = check_samples(Recording(times * per, places), TABLE, seconds, "a.csv")
    except BadInputFile as error:
        said = (str(error),)
    assert len(said) == 1 and "t " in said[0]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"scene": "ball"}, ("ball", "--scene", "solo, hold, master_slave")),
        ({"scene": "imitation"}, ("imitation", "--scene")),
        ({"scene": "solo", "path": "circle"}, ("path = circle", "leave out --path")),
    ],
)
def test_hand_samples_for_an_experiment_without_a_guided_hand_are_refused(
    given: dict[str, str], words: tuple[str, ...]
) -> None:
    with pytest.raises(BadInputFile) as caught:
        check_samples(Recording(T, PLACES), given_settings(**given), 3.0, "a.csv")
    assert all(word in str(caught.value) for word in words)


def test_every_scene_with_a_guided_hand_accepts_hand_samples() -> None:
    for scene in ("solo", "hold", "master_slave"):
        settings = given_settings(scene=scene)
        assert check_samples(Recording(T, near_the_hand(settings)), settings, 3.0, "a.csv") == ()


def written(path: Path, times: Array) -> Path:
    rows = "\n".join(
        ",".join(map(repr, (t, *place))) for t, place in zip(times.tolist(), PLACES.tolist(), strict=True)
    )
    path.write_text(f"t,x,y,z\n{rows}\n", encoding="utf-8")
    return path


def test_a_run_reports_bad_samples_before_it_begins(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["run", "--rig", "table", "--seconds", "0.2", "--inputs"]
    assert main([*command, str(written(tmp_path / "ros.csv", T + EPOCH))]) == 2
    out, error = capsys.readouterr()
    assert out == "" and error.count("\n") == 1 and "t begins at 1764275000" in error
    # Unlikely samples do not stop it, and the summary stays JSON.
    assert main([*command, str(written(tmp_path / "ms.csv", T * 1e3))]) == 0
    out, error = capsys.readouterr()
    assert json.loads(out)["steps"] == 40 and [
        line for line in error.splitlines() if "warning" in line and "milliseconds" in line
    ]
    assert main([*command, str(written(tmp_path / "good.csv", T))]) == 0
    assert "warning" not in capsys.readouterr().err


def test_the_time_stamps_of_a_bag_are_read_exactly() -> None:
    rows = "".join(
        f"{EPOCH + t:.6f},{x:.6f},{y:.6f},{z:.6f}\n" for t, (x, y, z) in zip(T, PLACES, strict=True)
    )
    recording = inputs_from(f"t,x,y,z\n{rows}".encode(), "a.csv")
    with pytest.raises(BadInputFile, match="t begins at 1764275000, "):
        check_samples(recording, TABLE, 2.0, "a.csv")
