"""Tables, curves and pictures: the numbers of the run, the same bytes every time."""

import csv
import gzip
import io
import math
import xml.etree.ElementTree as ET
from typing import get_args

import numpy as np
import pytest
from PIL import Image

from app.features.exports import csv_table as table_module
from app.features.exports.csv_table import changes, csv_bytes, csv_suffix
from app.features.exports.plot_pictures import (
    PictureKind,
    caption,
    embedded,
    inline_svg,
    mathtext,
    picture_bytes,
)
from app.features.exports.recorded_curves import (
    MOMENTS,
    OF_OTHER_RUNS,
    POINTS,
    Curves,
    Panel,
    thinned_table,
    without_tags,
)
from app.plots.plot_choice import possible_details
from app.plots.time_plots import time_plot_of
from app.plots.time_series import COLUMNS, NAMES, RollingSeries
from app.settings import Details
from scenes.history import COLUMN
from scenes.rerun import newest_steps
from scenes.settings import named_values
from scenes.simulation import Simulation
from tests.app.recording.runs import SCENES, piece
from tests.scenes.helpers import given_settings


def read(data: bytes) -> tuple[dict[str, str], list[str], list[list[str]]]:
    lines = data.decode().splitlines()
    settings = dict(line[2:].split(" = ", 1) for line in lines if line.startswith("#"))
    rows = list(csv.reader(line for line in lines if not line.startswith("#")))
    return settings, rows[0], rows[1:]


@pytest.mark.parametrize("scene", SCENES)
def test_the_table_holds_every_number_of_the_last_seconds(scene: str) -> None:
    recorded, table = piece(scene)
    settings, header, rows = read(csv_bytes(recorded, 1.5))
    assert len(rows) == 300 and csv_bytes(recorded, 1.5) == csv_bytes(recorded, 1.5)
    for name in ("t", "d", "lambda", "e2", "u", "w"):
        column = [float(row[header.index(name)]) for row in rows]
        assert np.array(column).tobytes() == table[-300:, COLUMN[name]].tobytes()
    named = named_values(recorded.settings)
    assert {key: settings[key] for key in named} == {key: str(value) for key, value in named.items()}
    assert settings["duet"]


def test_changed_settings_are_listed_with_their_time() -> None:
    recorded, _ = piece("hold", 3.0, 99.0, lively=True)
    changed = [(1.355, "dm", 0.11), (2.105, "k", 3.0), (2.105, "dt", 0.004), (2.105, "v", 0.4)]
    assert [(round(time, 3), key, value) for time, key, value in changes(recorded)] == changed
    settings, _, _ = read(csv_bytes(recorded, math.inf))
    assert (settings["dm"], settings["from 1.355 s on: dm"], settings["from 2.105 s on: k"]) == (
        "0.15",
        "0.11",
        "3.0",
    )
    # Changes before the first row of a shorter table appear as plain settings.
    settings, _, rows = read(csv_bytes(recorded, 0.6))
    assert (
        settings["dm"] == "0.11"
        and settings["k"] == "3.0"
        and not any(key.startswith("from") for key in settings)
    )
    assert float(rows[0][0]) == pytest.approx(2.4, abs=0.005)


def test_a_large_table_is_compressed(monkeypatch: pytest.MonkeyPatch) -> None:
    recorded, _ = piece("hold", 1.0)
    plain_table = csv_bytes(recorded, 1.0)
    monkeypatch.setattr(table_module, "LARGEST", 1000)
    small = csv_bytes(recorded, 1.0)
    assert gzip.decompress(small) == plain_table and small == csv_bytes(recorded, 1.0)
    assert (csv_suffix(plain_table), csv_suffix(small)) == (".csv", ".csv.gz")


@pytest.mark.parametrize("scene", SCENES)
def test_curves_equal_the_plots_of_the_page(scene: str) -> None:
    recorded, table = piece(scene)
    simulation, buffer = Simulation(recorded.settings), RollingSeries()
    curves = Curves(recorded, table)
    rows = {round(t, 9): i for i, t in enumerate(curves.times.tolist())}
    seen = 0
    for target in recorded.targets():
        simulation.step(target)
        buffer.feed(simulation)
        # The newest bin contains the newest step; d and e² are its extremes.
        newest_bin = buffer.newest(list(range(len(NAMES))))
        row = rows[round(float(newest_bin[0][-1]), 9)]
        if simulation.steps % 100 == 0 and len(newest_bin[0]) > 1:
            seen += 1
            for name in set(NAMES) - {"t", "d", "e", "e2", "changes"}:
                page = newest_bin[1:][COLUMNS[name]][-1]
                if math.isnan(page) and (name == "elbow" or name.startswith("other_")):
                    # The page does not compute what it does not plot here.
                    continue
                mine = curves.column(name)[row]
                np.testing.assert_allclose(mine, page, rtol=1e-12, atol=1e-12, err_msg=name)
    assert seen >= 5


def test_d_m_follows_its_changes() -> None:
    recorded, table = piece("hold", 3.0, 99.0, lively=True)
    curves = Curves(recorded, table)
    critical = curves.column("d_m")
    np.testing.assert_array_equal(critical, np.where(curves.times < 1.355 - 1e-9, 0.15, 0.11))
    assert newest_steps(recorded, math.inf) == newest_steps(recorded, 99.0) == len(table)
    assert newest_steps(recorded, 0.0) == 1
    part = Curves(recorded, table[-newest_steps(recorded, 1.0) :])
    np.testing.assert_array_equal(part.column("v"), curves.column("v")[-len(part.times) :])
    with pytest.raises(KeyError):
        curves.column("mood")


def test_thinning_keeps_dips_peaks_and_jumps() -> None:
    table = np.zeros((5 * POINTS, 40))
    table[:, COLUMN["t"]] = np.arange(len(table))
    table[:, COLUMN["d"]] = 1.0
    table[4321, COLUMN["d"]], table[77, COLUMN["e2"]], table[500, COLUMN["e2_b"]] = 0.1, 9.0, 5.0
    table[6543:, 30] = 2.0
    table[9000:9900:2, 35] = 1.0
    rows, chosen = thinned_table(table)
    assert rows.tobytes() == table[chosen].tobytes() and len(rows) <= POINTS and chosen[-1] == len(table) - 1
    assert {77, 500, 4321, 6542, 6543} <= set(chosen.tolist())
    # Chatter is a band: each bin keeps both extremes.
    chatter = rows[(chosen > 9000) & (chosen < 9900), 35]
    assert (
        np.count_nonzero(chatter == 1.0) > 20 and np.count_nonzero(chatter == 0.0) > 20 and len(chatter) < 450
    )
    few, ends = thinned_table(table[:10])
    assert few.tobytes() == table[:10].tobytes() and ends.tolist() == list(range(10))


@pytest.mark.parametrize("scene", SCENES)
def test_every_choice_is_a_panel(scene: str) -> None:
    recorded, table = piece(scene, 1.0)
    curves = Curves(recorded, table, "dark")
    for details in get_args(Details):
        if details not in possible_details(recorded.settings):
            continue
        panels: tuple[Panel, ...] = curves.panels(details)
        assert len(panels) == 2 + (details not in ("none", *OF_OTHER_RUNS)) + (
            scene == "imitation" and details == "follow"
        )
        for panel in panels:
            assert panel.title and "<" not in panel.title and (panel.strokes or panel.note)
            for stroke in panel.strokes:
                assert len(stroke.values) == len(panel.times) and stroke.colour.startswith("#")
                assert not np.isinf(stroke.values).any()


def test_stability_is_computed_along_the_run_or_a_reason_is_given() -> None:
    recorded, table = piece("hold", 6.0)
    panel = Curves(recorded, table).panels("stability")[2]
    assert len(panel.times) == MOMENTS and [s.name for s in panel.strokes] == ["eigenvalue / K", "1 − λρ²"]
    survival = panel.strokes[1].values
    # The remaining share is between 1 − λ and 1.
    rows = np.searchsorted(table[:, COLUMN["t"]], panel.times)
    lam = table[rows, COLUMN["lambda"]]
    assert lam.max() > 0.1 and (survival <= 1.0 + 1e-9).all() and (survival >= 1.0 - lam - 1e-9).all()
    other, rows = piece("hold", 0.5, law="barrier_qp")
    assert "says nothing" in Curves(other, rows).panels("stability")[2].note


def test_caption_and_legend_read_as_on_the_page() -> None:
    line = caption(given_settings(law="strict_switched", dm=0.2, v=0.4, k=3.0))
    assert (
        "Hold (Fig. 5)" in line
        and "switched at $d_m$" in line
        and "$d_m$ = 200 mm" in line
        and "K = 3/s" in line
    )
    slave = time_plot_of("follow", Simulation(given_settings(scene="master_slave", following="identical"), 1))
    assert slave.legend() == (*(((f"j{i}", "", str(i))) for i in range(1, 5)), ("", "dash", "master"))
    assert (
        without_tags("a <b class='d'>d</b> [m]") == "a d [m]"
        and mathtext("d<sub>m</sub>") == r"d$_{\mathrm{m}}$"
    )


PICTURES: list[tuple[str, Details, PictureKind, bool]] = [
    *(("hold", "pairs", "png", True), ("solo", "joints", "svg", True)),
    *(("hold", "laws", "svg", False), ("ball", "curve", "svg", False), ("imitation", "follow", "svg", False)),
]
"""Experiment, plots, kind of picture, and True to draw it twice."""


@pytest.mark.parametrize(("scene", "details", "kind", "twice"), PICTURES)
def test_every_experiment_has_a_reproducible_picture(
    scene: str, details: Details, kind: PictureKind, twice: bool
) -> None:
    recorded, _ = piece(scene, 1.0, lively=True)
    picture = picture_bytes(recorded, 0.9, details, kind)
    assert not twice or picture == picture_bytes(recorded, 0.9, details, kind)
    if kind == "svg":
        assert ET.fromstring(picture).tag.endswith("svg")


def test_pictures_can_be_opened_and_grow_with_their_content() -> None:
    recorded, _ = piece("hold", 1.5)
    sizes = []
    for details in ("none", "lambda"):
        with Image.open(io.BytesIO(picture_bytes(recorded, 1.0, details, "png"))) as picture:
            sizes.append(picture.size)
            # It contains the colour of d.
            assert picture.convert("RGB").getextrema() != ((255, 255), (255, 255), (255, 255))
    assert sizes[0][0] == sizes[1][0] and sizes[1][1] > sizes[0][1] + 200


def test_an_svg_does_not_affect_the_page_around_it() -> None:
    recorded, _ = piece("hold", 1.0)
    svg = inline_svg(recorded, "one", only=("lambda",))
    root = ET.fromstring(svg)
    ids = [element.attrib["id"] for element in root.iter() if "id" in element.attrib]
    assert ids and len(ids) == len(set(ids)) and all(name.startswith("one-") for name in ids)
    used = [value for element in root.iter() for key, value in element.attrib.items() if key.endswith("href")]
    assert used and {name.removeprefix("#") for name in used} <= set(ids)
    clips = [
        value[5:-1]
        for element in root.iter()
        if (value := element.attrib.get("clip-path", "")).startswith("url(#")
    ]
    assert clips and set(clips) <= set(ids)
    assert "viewBox" in root.attrib and not {"width", "height"} & set(root.attrib) and "<metadata" not in svg
    assert (
        embedded('<?xml?><svg width="1" height="2" viewBox="0 0 1 2"></svg>', "a")
        == '<svg viewBox="0 0 1 2"></svg>'
    )
