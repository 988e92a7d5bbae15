"""Lesson cases of the core's `test_sample_check.py`."""

from pathlib import Path

import pytest

from app.features.lessons.blocks import Table
from app.features.lessons.markdown import Fault
from app.features.lessons.setups import read_setup, usual_setup
from tests.scenes.test_sample_check import EPOCH, T, written


def test_an_input_file_outside_the_runs_time_is_a_fault_of_the_lesson(tmp_path: Path) -> None:

    written(tmp_path / "ros.csv", T + EPOCH)
    written(tmp_path / "good.csv", T)
    base = usual_setup(tmp_path).with_changes((("rig", "table"),))
    data = {"seconds": 3.0, "input": {"file": "ros.csv"}}
    with pytest.raises(Fault, match="since 1970"):
        read_setup(Table(data, [(1, "input = …")], 1), base)
    assert (
        read_setup(Table({**data, "input": {"file": "good.csv"}}, [(1, "input = …")], 1), base).input.name
        == "good.csv"
    )
