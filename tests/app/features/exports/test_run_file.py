"""A run as a file: restored bit for bit, with differences described, and harmless whatever it contains."""

import io
import math
import zipfile
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.recording import outcome as outcome_module
from app.recording import run_file as run_file_module
from app.recording.outcome import CLOSE, compare_run, history_columns, outcome_of
from app.recording.run_file import (
    LONGEST_ENTRY,
    NAMES,
    SavedRun,
    changed_versions,
    load_run,
    made_from,
    made_here,
    saved_bytes,
    saved_from,
    verify,
)
from controllers.errors import BadInputFile, BadSetting
from scenes.history import unit_of
from scenes.inputs_file import recorded_from
from scenes.settings import changed
from scenes.simulation import Simulation
from tests.app.features.said import lines_of, without_numbers
from tests.app.recording.runs import SCENES, piece
from tests.approved import Approve
from tests.scenes.inputs.helpers import as_bytes, rewritten


@cache
def saved() -> SavedRun:
    return saved_from(saved_bytes(piece("hold")[0]), "a.npz")


@pytest.mark.parametrize("scene", SCENES)
def test_a_file_is_recomputed_bit_for_bit(scene: str) -> None:
    recorded, table = piece(scene, 3.0, 1.2, lively=True)
    assert recorded.begin >= 1.0 and len(recorded.stretches) >= 2
    data = saved_bytes(recorded, table[-1].tobytes())
    assert data == saved_bytes(recorded) and len(data) < 0.7 * table.nbytes
    again = recorded_from(data, "a.npz")
    assert again.steps == recorded.steps and again.settings == recorded.settings
    loaded = load_run(data, "a.npz")
    assert loaded.verdict == "exact" and f"all {recorded.steps} steps" in loaded.words
    assert loaded.recorded.stretches[-1].settings == recorded.stretches[-1].settings
    assert loaded.recorded.steps == recorded.steps
    # The saved outcome comes from the original run, not from the recomputed one.
    kept = saved_from(data, "a.npz").outcome
    assert kept.rows.tobytes() == outcome_of(table, kept.columns).rows.tobytes()


def test_a_file_of_an_earlier_version_is_read() -> None:
    """Saved when the folders of `app` had other names and an upper arm beside a pedestal began elsewhere."""
    loaded = load_run(Path(__file__).with_name("earlier.duet.npz").read_bytes(), "earlier.duet.npz")
    assert loaded.recorded.steps == 60 and loaded.recorded.settings.scene == "hold"
    comparison = loaded.comparison
    assert loaded.verdict == "differs" and comparison.steps_then == 60
    assert comparison.first is not None and comparison.first.column in ("d", "law_d", "lambda")


def with_setting(file: SavedRun, key: str, value: float) -> SavedRun:
    stretches = tuple(s._replace(settings=changed(s.settings, key, value)) for s in file.recorded.stretches)
    return replace(file, recorded=replace(file.recorded, stretches=stretches))


def test_another_setting_gives_another_run_and_the_first_step_is_named(approve: Approve) -> None:
    found = verify(with_setting(saved(), "k", 2.5))
    assert found.verdict == "differs"
    recorded, table = piece("hold")
    again = Simulation(changed(recorded.settings, "k", 2.5))
    for target in recorded.targets():
        again.step(target)
    first = next(
        i
        for i, (a, b) in enumerate(zip(table, again.history.table(), strict=True))
        if a.tobytes() != b.tobytes()
    )
    comparison = found.comparison
    assert comparison.first_step == first and f"number {first + 1} of {recorded.steps}." in found.words
    assert comparison.first is not None and comparison.largest is not None
    assert comparison.first.step == first and comparison.first.time == table[first, 0]
    # Size and place of the difference follow from the numbers themselves.
    by = np.abs(np.nan_to_num(table) - np.nan_to_num(again.history.table()))
    assert comparison.largest.by == by.max() > CLOSE
    row, column = np.unravel_index(int(by.argmax()), by.shape)
    assert (comparison.largest.step, comparison.largest.column) == (row, history_columns(again)[int(column)])
    assert comparison.largest.words(again.settings.experiment.error_unit) in found.words
    approve("comparison with another gain.txt", without_numbers(f"{found.words}\n"))


def test_differences_in_the_last_bits_count_as_the_same_run(approve: Approve) -> None:
    file = with_setting(replace(saved(), made={**made_here(), "numpy": "1.0"}), "k", 2.0 + 1e-12)
    found = verify(file)
    assert found.verdict == "close"
    # Column and place of the largest difference depend on the machine.
    approve("comparison with last bits.txt", f"{found.words.partition('. ')[0]}.\n")
    assert f"numpy 1.0 then, {np.__version__} now" in found.words and found.words.count(" then, ") == 1


def test_runs_of_another_length_or_with_other_columns_are_compared() -> None:
    recorded, table = piece("hold")
    columns = history_columns(Simulation(recorded.settings, 1))
    found = compare_run(outcome_of(table, columns), table[:-7], columns)
    assert (found.exact, found.close, found.first_step) == (False, False, len(table) - 7)
    assert (found.steps_then, found.steps_now, found.largest) == (len(table), len(table) - 7, None)
    older = outcome_of(table[:, 1:], columns[1:])
    assert compare_run(older, table, columns).largest is None
    other = table.copy()
    other[5, columns.index("left_q2")] += 0.25
    found = compare_run(older, other, columns)
    assert found.first_step is None and found.largest is not None
    assert (found.largest.column, found.largest.by, found.largest.step) == ("left_q2", 0.25, 5)


def test_long_runs_keep_evenly_spread_steps_and_find_the_first_difference(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(outcome_module, "MOST_ROWS", 50)
    table = np.arange(600.0)[:, None] * np.array([0.005, 1.0, -2.0])
    kept = outcome_of(table, ("t", "d", "u"))
    assert len(kept.places) <= 51 and (kept.places[0], kept.places[-1]) == (0, 599)
    other = table.copy()
    other[307:, 1] += 3.0
    found = compare_run(kept, other, ("t", "d", "u"))
    assert found.first_step == 307 and found.first is not None
    assert 307 <= found.first.step < 307 + 12 and (found.first.column, found.first.by) == ("d", 3.0)


def test_missing_numbers_differ_from_numbers(approve: Approve) -> None:
    table = np.array([[0.0, 1.0, np.nan], [0.1, 1.0, np.nan]])
    kept = outcome_of(table, ("t", "d", "e2_b"))
    # The bits of a nan do not matter, but nan differs from 0.
    same = table.copy()
    same[:, 2] = -np.float64(np.nan)
    assert compare_run(kept, same, kept.columns).exact
    other = table.copy()
    other[1, 2] = 0.0
    found = compare_run(kept, other, kept.columns)
    assert found.largest is not None and math.isinf(found.largest.by) and not found.close
    approve("comparison with nan.txt", f"{found.largest.words('m²')}\n")


def test_units() -> None:
    units = {"t": "s", "d": "m", "e2": "rad²", "lambda": "", "w_law_b": "m/s", "pair": "", "left_q3": "rad"}
    units |= {"left_dq3": "rad/s", "right_qd1": "rad", "ball_q_x": "m", "ball_dq_x": "m/s"}
    assert {column: unit_of(column, "rad²") for column in units} == units


@pytest.fixture(scope="module")
def data() -> bytes:
    return saved_bytes(piece("hold", 1.0)[0])


WRONG_PARTS: dict[str, dict[str, Any]] = {
    "no hashes": {"outcome_hashes": None},
    "no codes": {"codes": None},
    "one place twice": {"outcome_places": np.array([5, 5], np.uint32)},
    "a place behind the end": {"outcome_places": np.array([0, 99999], np.uint32)},
    "rows of bytes": {"outcome_rows": np.zeros((2, 8, 3), np.uint8)},
    "rows of floats": {"outcome_rows": np.zeros((2, 8, 3), float)},
    "cut": {"outcome_about": as_bytes("{")},
    "a list": {"outcome_about": as_bytes("[1]")},
    "a number of columns": {"outcome_about": as_bytes('{"columns": 4, "digest": ""}')},
    "other columns": {"outcome_about": as_bytes('{"columns": ["<b>\\n"], "digest": ""}')},
    "few hashes": {"outcome_hashes": np.zeros(3, np.uint32)},
}


def test_a_wrong_part_is_refused_and_named(data: bytes, approve: Approve) -> None:
    said = dict[str, str]()
    for case, parts in WRONG_PARTS.items():
        with pytest.raises(BadInputFile) as caught:
            load_run(rewritten(data, **parts), "mine.npz")
        said[case] = str(caught.value)
    approve("refused parts.txt", lines_of(said))


def test_a_part_that_is_not_an_array_does_no_harm(data: bytes) -> None:
    with zipfile.ZipFile(io.BytesIO(data)) as file:
        parts = {name: file.read(name) for name in file.namelist()}
    for name in parts:
        out = io.BytesIO()
        with zipfile.ZipFile(out, "w") as file:
            for other, content in parts.items():
                file.writestr(other, b"no array" if other == name else content)
        if name == "made.npy":
            assert load_run(out.getvalue(), "mine.npz").verdict == "exact"
            continue
        with pytest.raises(BadInputFile, match=r"^mine\.npz: "):
            load_run(out.getvalue(), "mine.npz")


@pytest.mark.parametrize("made", [None, "{", "[]", '{"numpy": 3}', '{"numpy": "%s"}' % ("x" * 500)])
def test_a_file_is_read_whatever_it_says_about_its_making(data: bytes, made: str | None) -> None:
    file = rewritten(data, **({} if made is None else {"made": as_bytes(made)}))
    assert load_run(file, "mine.npz").verdict == "exact"
    assert max(map(len, saved_from(file, "mine.npz").made.values()), default=0) <= LONGEST_ENTRY


def test_an_impossible_or_too_long_run_is_refused(data: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(*_: object, **__: object) -> None:
        raise BadSetting("robot = panda needs a package.")

    with monkeypatch.context() as here, pytest.raises(BadInputFile, match=r"mine\.npz: robot = panda"):
        here.setattr(run_file_module, "rerun", missing)
        load_run(data, "mine.npz")
    with monkeypatch.context() as here, pytest.raises(BadInputFile, match="of 1 s; at most 0 s"):
        here.setattr(run_file_module, "LONGEST", 0.5)
        load_run(data, "mine.npz")


@settings(max_examples=60)
@given(st.integers(0, 10**9), st.integers(1, 255), st.booleans())
def test_one_wrong_byte_is_refused_or_changes_nothing(data: bytes, place: int, flip: int, cut: bool) -> None:
    bad = bytearray(data)
    bad[place % len(data)] ^= flip
    if cut:
        del bad[place % len(data) :]
    try:
        file = saved_from(bytes(bad), "mine.npz")
    except BadInputFile as error:
        assert str(error).startswith("mine.npz: ")
    else:
        # Each part has a checksum: only the archive's own description can be wrong.
        assert file.outcome.digest == saved_from(data, "good").outcome.digest


def test_no_code_in_a_file_is_executed(data: bytes) -> None:
    class Bomb:
        def __reduce__(self) -> tuple[Any, ...]:
            return exec, ("raise SystemExit('boom')",)

    out = io.BytesIO(data)
    with zipfile.ZipFile(out, "a") as archive:
        part = io.BytesIO()
        np.save(part, np.array([Bomb()], object), allow_pickle=True)
        archive.writestr("outcome_more.npy", part.getvalue())
    with pytest.raises(BadInputFile, match=r"damaged\.$"):
        load_run(out.getvalue(), "mine.npz")


def test_a_file_names_the_versions_that_made_it() -> None:
    here = made_here()
    assert set(here) == set(NAMES) and made_from(here) == here and not changed_versions(here, here)
    assert changed_versions({}, here)[0].startswith("Duet unknown then, ")
