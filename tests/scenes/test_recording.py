"""Files of inputs and results: faults are named with their line, writing is complete or has no effect."""

import csv
import errno
import io
import math
import os
import threading
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from controllers.errors import BadInputFile, DuetError
from scenes.files import path_inside, read_file, replacing
from scenes.recording import Recording, read_inputs, write_table
from scenes.settings import RunSettings, changed, values
from scenes.simulation import Simulation
from tests.scenes.helpers import column, given_settings, hold_settings, play, wander

GOOD = "t,x,y,z\n0,0.1,0.2,0.3\n1,0.2,0.2,0.3\n2.5,0.2,-0.4,0.3\n"


def reading(folder: Path, content: str | bytes) -> Recording:
    path = folder / "hand.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_inputs(path)


CLOTHES = {
    "bom": "\ufeff" + GOOD,
    "crlf": GOOD.replace("\n", "\r\n"),
    "comments and blank lines": "# a comment\n\n" + GOOD.replace("\n1,", "\n# another, 1, 2, 3\n   \n1,"),
    "header": GOOD.replace("t,x,y,z", " T , X,y ,Z"),
    "spaces": GOOD.replace(",", " , "),
    "no last newline": GOOD.rstrip("\n"),
    "quotes": GOOD.replace("0.1", '"0.1"'),
}


@pytest.mark.parametrize("clothes", CLOTHES)
def test_the_same_file_in_other_formats(tmp_path: Path, clothes: str) -> None:
    recording = reading(tmp_path, CLOTHES[clothes])
    assert_allclose(recording.times, [0.0, 1.0, 2.5])
    assert_allclose(recording.positions, [[0.1, 0.2, 0.3], [0.2, 0.2, 0.3], [0.2, -0.4, 0.3]])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("t,x,y\n0,0,0\n", ("line 1", "t,x,y,z")), ("# why\nx,y,z,t\n0,0,0,0\n", ("line 2", "header")),
        ("0,0,0,0\n", ("line 1", "header")), ("t,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n", ("line 1", "qw,qx,qy,qz")),
        ("t,x,y,z\n0,0,0\n", ("line 2", "3 values", "4")), ("t,x,y,z\n0,0,0,0\n1,0,0,0,0\n", ("line 3", "5 values")),
        ("t,x,y,z\n0,0,zero,0\n", ("line 2", "y", "'zero'", "not a number")),
        ("t,x,y,z\n0,0,,0\n", ("line 2", "y", "not a number")),
        ("t,x,y,z\n0,0,nan,0\n", ("line 2", "y", "nan", "not finite")),
        ("t,x,y,z\n0,-inf,0,0\n", ("line 2", "x", "not finite")), ("t,x,y,z\n0,0,0,1e999\n", ("line 2", "z", "not finite")),
        ("t,x,y,z\n0,0,0,350.5\n", ("line 2", "z", "350.5", "metres")),
        ("t,x,y,z\n0,0,0,-10.001\n", ("line 2", "z", "metres")),
        ("t,x,y,z\n0,0,0,0\n#\n\n0,0,0,0\n", ("line 5", "t = 0", "increase")),
        ("t,x,y,z\n1,0,0,0\n0.5,0,0,0\n", ("line 3", "t = 0.5", "after 1")),
        ("t,x,y,z,qw,qx,qy,qz\n0,0,0,0,0,0,0,0\n", ("line 2", "not an orientation")),
        ("t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0\n", ("line 2", "7 values", "8")),
        *((text, ("no samples",)) for text in ("t,x,y,z\n", "", "# only words\n\n")),
        *((f"t,x,y,z\n0,0,0,{letter * 200_000}\n", ("line 2",)) for letter in "1x"),
        (b"\xff\xfet\x00,", ("not a text file",)), (b"t,x,y,z\n0,0,0,\x80\n", ("not a text file",)),
        (None, ("cannot be read",)), ("a folder", ("cannot be read",)),
    ],
)  # fmt: skip
def test_a_fault_is_reported_in_one_line_with_its_place(
    tmp_path: Path, text: str | bytes | None, words: tuple[str, ...]
) -> None:
    path = tmp_path / "hand.csv"
    if text == "a folder":
        path.mkdir()
    with pytest.raises(BadInputFile) as caught:
        read_inputs(path) if text in (None, "a folder") else reading(tmp_path, text)
    message = str(caught.value)
    assert isinstance(caught.value, DuetError) and "\n" not in message and len(message) < 400
    assert all(word in message for word in (str(path), *words))


@given(
    st.binary(max_size=200)
    | st.text(max_size=200).map(str.encode)
    | st.text("0123456789.,-e\nnaift#\"' ", max_size=80).map(str.encode)
)
def test_any_bytes_are_read_as_a_recording_or_refused(
    tmp_path_factory: pytest.TempPathFactory, content: bytes
) -> None:
    path = tmp_path_factory.getbasetemp() / "any.csv"
    for head in (b"", b"t,x,y,z\n", b"t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n"):
        path.write_bytes(head + content)
        try:
            recording = read_inputs(path)
        except BadInputFile as error:
            assert str(path) in str(error)
        else:
            assert np.isfinite(recording.positions).all() and (np.diff(recording.times) > 0.0).all()


def test_rotations_are_interpolated_evenly_the_short_way(tmp_path: Path) -> None:
    # Half a turn about z in 2 s, with an unnormalised quaternion; then 90°, also with −q.
    h, poses = 0.70710678, "t,x,y,z,qw,qx,qy,qz\n0,0,0,1,1,0,0,0\n"
    half = (
        f"{poses}2,0,0,1,0,0,0,2\n",
        [(0.0, 0.0), (0.5, 45.0), (1.0, 90.0), (1.7, 153.0), (2.0, 180.0), (9.0, 180.0)],
    )
    quarters = [(f"{poses}1,0,0,1,{w},0,0,{w}\n", [(0.5, 45.0), (1.0, 90.0)]) for w in (h, -h)]
    for text, expected in (half, *quarters):
        recording = reading(tmp_path, text)
        for time, angle in expected:
            rotation = recording.target(time).rotation
            assert rotation is not None
            c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
            assert_allclose(rotation, [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], atol=1e-7)
    assert reading(tmp_path, GOOD).target(0.0).rotation is None


@given(
    st.lists(st.tuples(st.floats(0.01, 2.0), st.floats(-1.0, 1.0)), min_size=1, max_size=12),
    st.floats(-1.0, 30.0),
)
def test_interpolation_is_numpys(samples: list[tuple[float, float]], time: float) -> None:
    times = np.cumsum([gap for gap, _ in samples])
    x = np.array([value for _, value in samples])
    recording = Recording(times, np.column_stack([x, -x, 2.0 * x]))
    for t in (time, *times.tolist()):
        expected = np.interp(t, times, x)
        assert_allclose(recording.target(t).position, [expected, -expected, 2.0 * expected], atol=1e-12)


JOINTS = [f"{side}_{kind}{i}" for kind in ("q", "dq") for side in ("left", "right") for i in range(1, 8)]
HEADER = ["t", "d", "lambda", "e2", "u", "w", "law_d", "w_law", "lever", "pair", *JOINTS]


def test_a_second_avoiding_arm_keeps_its_columns_after_it_stops_avoiding() -> None:
    simulation = Simulation(given_settings(scene="master_slave", avoid="both"))
    source = simulation.source()
    for avoid in ("both", "free"):
        simulation.apply(changed(simulation.settings, "avoid", avoid))
        for _ in range(20):
            simulation.step(source.target(simulation.time))
    out = io.StringIO(newline="")
    write_table(out, simulation, simulation.history.table(), {})
    header, *rows = csv.reader(line for line in out.getvalue().splitlines() if not line.startswith("#"))
    second = [float(row[header.index("w_law_b")]) for row in rows]
    assert len(rows) == 40 and np.isfinite(second[:20]).all() and np.isnan(second[20:]).all()


def exported(seed: int) -> tuple[str, Simulation]:
    simulation = Simulation(hold_settings("table", seed=seed))
    table = play(simulation, wander(simulation, 60, seed))
    out = io.StringIO(newline="")
    write_table(out, simulation, table, values(simulation.settings))
    return out.getvalue(), simulation


def test_tables_of_a_run() -> None:
    # Settings as # lines, the exact header, one row per step, and numbers that read back to the same bits.
    text, simulation = exported(1)
    lines = text.split("\n")
    count = len(values(simulation.settings))
    assert lines[:count] == [f"# {key} = {value}" for key, value in values(simulation.settings).items()]
    joints = ", ".join(f"{name} [{'rad/s' if 'dq' in name else 'rad'}]" for name in JOINTS)
    scalars = (
        "t [s], d [m], lambda [1], e2 [m²], u [m/s], w [m/s], law_d [m], w_law [m/s], lever [1], pair [names]"
    )
    assert lines[count] == f"# units = {scalars}, {joints}"
    assert lines[count + 1] == ",".join(HEADER) and lines[-1] == ""
    rows = list(csv.reader(lines[count + 2 : -1]))
    table = simulation.history.table()
    assert len(rows) == len(table) == 60
    for i, name in enumerate(HEADER[:9]):
        assert [float(row[i]) for row in rows] == column(table, name).tolist()
    names = simulation.detector.pair_names
    assert [row[9] for row in rows] == [" / ".join(names[int(i)]) for i in column(table, "pair")]
    history = simulation.history
    joints = np.hstack([history.positions(table), history.velocities(table)])
    assert [[float(cell) for cell in row[10:]] for row in rows] == joints.tolist()
    assert exported(1)[0] == text != exported(2)[0]
    text, simulation = exported(3)
    rebuilt = RunSettings(rig="torso")
    for line in text.split("\n"):
        if line.startswith("# ") and not line.startswith("# units"):
            key, value = line[2:].split(" = ")
            rebuilt = changed(rebuilt, key, value)
    assert rebuilt == simulation.settings


posix = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names")


@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError, UnicodeError])
def test_an_interrupted_write_keeps_the_old_file(tmp_path: Path, error: type[BaseException]) -> None:
    path = tmp_path / "file"
    for before in (None, "old"):
        if before is not None:
            path.write_text(before, encoding="utf-8")
        with pytest.raises(error), replacing(path) as draft:
            draft.write_text("half", encoding="utf-8")
            assert draft.parent == path.parent and draft != path
            raise error
        assert {p.name: p.read_text(encoding="utf-8") for p in tmp_path.iterdir()} == (
            {"file": before} if before else {}
        )
    with replacing(path) as draft:
        draft.write_text("new", encoding="utf-8")
        assert path.read_text(encoding="utf-8") == "old"
    assert path.read_text(encoding="utf-8") == "new" and list(tmp_path.iterdir()) == [path]


@posix
def test_links_devices_and_pipes_are_written_through(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("folder/file")
    (tmp_path / "folder").mkdir()
    with replacing(tmp_path / "link") as draft:
        draft.write_text("through", encoding="utf-8")
    assert (tmp_path / "link").is_symlink() and (tmp_path / "folder/file").read_text(
        encoding="utf-8"
    ) == "through"
    with replacing(Path(os.devnull)) as draft:
        assert draft == Path(os.devnull)
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    # No process reads it.
    with pytest.raises(OSError), replacing(pipe):
        raise AssertionError("it must not come to that")
    read: list[str] = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_text(encoding="utf-8")))
    reader.start()
    while not read and reader.is_alive():
        try:
            with replacing(pipe) as draft:
                draft.write_text("words", encoding="utf-8")
            break
        except OSError:
            # The reader is not ready yet.
            continue
    reader.join()
    assert read == ["words"] and pipe.is_fifo()


def test_files_and_names_stay_in_their_folder(tmp_path: Path) -> None:
    with pytest.raises(IsADirectoryError), replacing(tmp_path):
        raise AssertionError("it must not come to that")
    (tmp_path / "loop").symlink_to("loop")
    assert path_inside(tmp_path, "a/../b") == Path(os.path.realpath(tmp_path / "b"))
    assert path_inside(tmp_path, "loop") is not None
    assert (
        path_inside(tmp_path, "../b") is None
        and path_inside(tmp_path, "b\0") is None
        and path_inside(tmp_path, "/b") is None
    )
    path = tmp_path / "file"
    path.write_bytes(b"\r\n\x1a0")
    assert read_file(path, 4) == b"\r\n\x1a0"
    with pytest.raises(OSError, match="larger") as error:
        read_file(path, 3)
    assert error.value.errno == errno.EFBIG
    for name in ("none", "a\0b"):
        with pytest.raises(FileNotFoundError):
            read_file(tmp_path / name, 3)
    with pytest.raises(OSError, match="a folder"):
        read_file(tmp_path, 3)
