"""Inputs and outcomes as files: every fault is told with its line, and what is written is complete and repeatable."""

import csv
import io
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from controllers.errors import BadInputFile, DuetError
from scenes.recording import Recording, read_inputs, write_table
from scenes.settings import RunSettings, changed, values
from scenes.simulation import Simulation
from tests.scenes.helpers import column, hold_settings, play, wander

GOOD = "t,x,y,z\n0,0.1,0.2,0.3\n1,0.2,0.2,0.3\n2.5,0.2,-0.4,0.3\n"
POSES = "t,x,y,z,qw,qx,qy,qz\n0,0,0,1,1,0,0,0\n2,0,0,1,0,0,0,2\n"

Write = Callable[[str | bytes], Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Write a file and say where it is."""

    def to_file(content: str | bytes) -> Path:
        path = tmp_path / "hand.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return to_file


def refused(path: Path, *words: str) -> None:
    """Check that a file is refused by one line that names it and says all the words."""
    with pytest.raises(BadInputFile) as caught:
        read_inputs(path)
    assert isinstance(caught.value, DuetError)
    text = str(caught.value)
    assert "\n" not in text
    assert len(text) < 400
    for word in (str(path), *words):
        assert word in text


@pytest.mark.parametrize(
    "text",
    [
        "\ufeff" + GOOD,
        GOOD.replace("\n", "\r\n"),
        "# a comment\n\n" + GOOD.replace("\n1,", "\n# another, 1, 2, 3\n   \n1,"),
        GOOD.replace("t,x,y,z", " T , X,y ,Z"),
        GOOD.replace(",", " , "),
        GOOD.rstrip("\n"),
        GOOD.replace("0.1", '"0.1"'),
    ],
    ids=["bom", "crlf", "comments", "header", "spaces", "no last newline", "quotes"],
)
def test_the_same_file_in_other_clothes(write: Write, text: str) -> None:
    """A BOM, Windows line ends, comments, blank lines, spaces, capitals and quotes change nothing."""
    recording = read_inputs(write(text))
    assert_allclose(recording.times, [0.0, 1.0, 2.5])
    assert_allclose(recording.positions[:, 1], [0.2, 0.2, -0.4])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("t,x,y\n0,0,0\n", ("line 1", "t,x,y,z")),
        ("# why\nx,y,z,t\n0,0,0,0\n", ("line 2", "header")),
        ("0,0,0,0\n", ("line 1", "header")),
        ("t,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n", ("line 1", "qw,qx,qy,qz")),
        ("t,x,y,z\n0,0,0\n", ("line 2", "3 values", "4")),
        ("t,x,y,z\n0,0,0,0\n1,0,0,0,0\n", ("line 3", "5 values")),
        ("t,x,y,z\n0,0,zero,0\n", ("line 2", "y", "'zero'", "not a number")),
        ("t,x,y,z\n0,0,,0\n", ("line 2", "y", "not a number")),
        ("t,x,y,z\n0,0,nan,0\n", ("line 2", "y", "nan", "not finite")),
        ("t,x,y,z\n0,-inf,0,0\n", ("line 2", "x", "not finite")),
        ("t,x,y,z\n0,0,0,1e999\n", ("line 2", "z", "not finite")),
        ("t,x,y,z\n0,0,0,350.5\n", ("line 2", "z", "350.5", "metres")),
        ("t,x,y,z\n0,0,0,-10.001\n", ("line 2", "z", "metres")),
        ("t,x,y,z\n0,0,0,0\n#\n\n0,0,0,0\n", ("line 5", "t = 0", "increase")),
        ("t,x,y,z\n1,0,0,0\n0.5,0,0,0\n", ("line 3", "t = 0.5", "after 1")),
        ("t,x,y,z,qw,qx,qy,qz\n0,0,0,0,0,0,0,0\n", ("line 2", "no orientation")),
        ("t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0\n", ("line 2", "7 values", "8")),
        ("t,x,y,z\n", ("no samples",)),
        ("", ("no samples",)),
        ("# only words\n\n", ("no samples",)),
        ("t,x,y,z\n0,0,0," + "1" * 200_000 + "\n", ("line 2",)),
        ("t,x,y,z\n0,0,0," + "x" * 200_000 + "\n", ("line 2",)),
    ],
)
def test_faults_are_told_with_their_line(write: Write, text: str, words: tuple[str, ...]) -> None:
    """What is wrong, in which line, and what would be right; never a traceback of something else."""
    refused(write(text), *words)


def test_files_that_cannot_be_read(tmp_path: Path, write: Write) -> None:
    """No such file, a folder, and bytes that are no text."""
    refused(tmp_path / "nowhere.csv", "cannot be read")
    refused(tmp_path, "cannot be read")
    refused(write(b"\xff\xfe\x00t\x00,"), "not a text file")
    refused(write(b"t,x,y,z\n0,0,0,\x80\n"), "not a text file")


@given(
    st.binary(max_size=200)
    | st.text(max_size=200).map(str.encode)
    | st.text("0123456789.,-e\nnaift#\"' ", max_size=80).map(str.encode)
)
def test_any_bytes_are_a_recording_or_refused(tmp_path_factory: pytest.TempPathFactory, content: bytes) -> None:
    """Whatever a file holds, also behind a good header: it is read, or `BadInputFile` says why not; nothing else is raised."""
    path = tmp_path_factory.getbasetemp() / "any.csv"
    for head in (b"", b"t,x,y,z\n", b"t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n"):
        path.write_bytes(head + content)
        try:
            recording = read_inputs(path)
        except BadInputFile as error:
            assert str(path) in str(error)
        else:
            assert np.isfinite(recording.positions).all()
            assert (np.diff(recording.times) > 0.0).all()


def test_interpolation_and_rotations(write: Write) -> None:
    # Linear between samples, at the first before them all, at the last ever after.
    recording = read_inputs(write(GOOD))
    for time, x, y in (
        (-5.0, 0.1, 0.2),
        (0.0, 0.1, 0.2),
        (0.25, 0.125, 0.2),
        (1.0, 0.2, 0.2),
        (1.75, 0.2, -0.1),
        (2.5, 0.2, -0.4),
    ):
        assert_allclose(recording.target(time).position, [x, y, 0.3], atol=1e-12)
    assert_allclose(recording.target(1e6).position, [0.2, -0.4, 0.3])
    # Half a turn about z in 2 s, given with a quaternion twice too long: a quarter turn at half time, at an even speed.
    recording = read_inputs(write(POSES))
    for time, angle in (
        (0.0, 0.0),
        (0.5, 0.25 * math.pi),
        (1.0, 0.5 * math.pi),
        (1.7, 0.85 * math.pi),
        (2.0, math.pi),
        (9.0, math.pi),
    ):
        rotation = recording.target(time).rotation
        assert rotation is not None
        c, s = math.cos(angle), math.sin(angle)
        assert_allclose(rotation, [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], atol=1e-9)
    # Times and positions come back as written.
    recording = read_inputs(write(GOOD))
    assert_allclose(recording.times, [0.0, 1.0, 2.5])
    assert_allclose(recording.positions, [[0.1, 0.2, 0.3], [0.2, 0.2, 0.3], [0.2, -0.4, 0.3]])
    assert recording.target(0.0).rotation is None


@given(st.lists(st.tuples(st.floats(0.01, 2.0), st.floats(-1.0, 1.0)), min_size=1, max_size=12), st.floats(-1.0, 30.0))
def test_interpolation_is_numpys(samples: list[tuple[float, float]], time: float) -> None:
    """Against numpy.interp, for any samples and any time, the sample times themselves included."""
    times = np.cumsum([gap for gap, _ in samples])
    x = np.array([value for _, value in samples])
    recording = Recording(times, np.column_stack([x, -x, 2.0 * x]))
    for t in (time, *times.tolist()):
        expected = np.interp(t, times, x)
        assert_allclose(recording.target(t).position, [expected, -expected, 2.0 * expected], atol=1e-12)


@pytest.mark.parametrize("sign", ["", "-"])
def test_rotations_take_the_short_way(write: Write, sign: str) -> None:
    """A quaternion and its negative are one orientation: between 0 and 90° lies 45°, not −135°."""
    h = f"{sign}0.70710678"
    recording = read_inputs(write(f"t,x,y,z,qw,qx,qy,qz\n0,0,0,1,1,0,0,0\n1,0,0,1,{h},0,0,{h}\n"))
    rotation = recording.target(0.5).rotation
    assert rotation is not None
    assert math.degrees(math.atan2(rotation[1, 0], rotation[0, 0])) == pytest.approx(45.0, abs=1e-4)


HEADER = (
    "t,d,lambda,e2,u,w,pair,"
    "left_q1,left_q2,left_q3,left_q4,left_q5,left_q6,left_q7,right_q1,right_q2,right_q3,right_q4,right_q5,right_q6,right_q7,"
    "left_dq1,left_dq2,left_dq3,left_dq4,left_dq5,left_dq6,left_dq7,"
    "right_dq1,right_dq2,right_dq3,right_dq4,right_dq5,right_dq6,right_dq7"
)


def exported(seed: int) -> tuple[str, Simulation]:
    """A short run as CSV."""
    simulation = Simulation(hold_settings("table", seed=seed))
    table = play(simulation, wander(simulation, 60, seed))
    out = io.StringIO(newline="")
    write_table(out, simulation, table, values(simulation.settings))
    return out.getvalue(), simulation


def test_tables_of_a_run() -> None:
    # Settings as # lines, the header to the letter, one row a step, and every number so that it reads back as the same bits.
    text, simulation = exported(1)
    lines = text.split("\n")
    count = len(values(simulation.settings))
    assert lines[:count] == [f"# {key} = {value}" for key, value in values(simulation.settings).items()]
    assert lines[count] == HEADER
    assert lines[-1] == ""
    rows = list(csv.reader(lines[count + 1 : -1]))
    table = simulation.history.table()
    assert len(rows) == len(table) == 60
    for name, i in (("t", 0), ("d", 1), ("lambda", 2), ("e2", 3), ("u", 4), ("w", 5)):
        assert [float(row[i]) for row in rows] == column(table, name).tolist()
    names = simulation.detector.pair_names
    assert [row[6] for row in rows] == [" / ".join(names[int(i)]) for i in column(table, "pair")]
    history = simulation.history
    joints = np.hstack([history.positions(table), history.velocities(table)])
    assert [[float(cell) for cell in row[7:]] for row in rows] == joints.tolist()
    # Two runs with the same settings and inputs write the same file; another seed another one (positive control).
    first, second, other = exported(1)[0], exported(1)[0], exported(2)[0]
    assert first == second
    assert first != other
    # A file's head holds every setting: as text it can be fed back.
    text, simulation = exported(3)
    rebuilt = RunSettings(rig="torso")
    for line in text.split("\n"):
        if line.startswith("# "):
            key, value = line[2:].split(" = ")
            rebuilt = changed(rebuilt, key, value)
    assert rebuilt == simulation.settings
