"""Peers in the same experiment: disagreeing engines are refused; w decides who keeps the distance."""

import importlib.util
import json
from dataclasses import replace
from functools import cache
from importlib import import_module
from importlib.machinery import ModuleSpec
from importlib.metadata import PackageNotFoundError
from typing import Any

import numpy as np
import pytest

from controllers.errors import BadSetting, DuetError
from controllers.kinematics import Array
from scenes.headless import run
from scenes.settings import RunSettings, changed
from tests.tools.bench import peers
from tests.tools.bench.__main__ import main
from tests.tools.bench.peer_method import Baked, bake
from tests.tools.bench.peer_ours import Ours
from tests.tools.bench.peers import PACKAGES, gate, measure_peers, needs_peers, peers_table

pytestmark = pytest.mark.thorough

POSE = RunSettings(task="pose")
needs_extra = pytest.mark.skipif(
    any(importlib.util.find_spec(module) is None for module in PACKAGES),
    reason="the peers are not installed: pip install -e '.[peers]'",
)


@cache
def baked(steps: int = 40) -> Baked:
    return bake(POSE, steps)


class Wrong(Ours):
    def __init__(self, spoilt: str) -> None:
        super().__init__(baked())
        self._spoilt = spoilt

    def distances(self, positions: Array) -> dict[tuple[str, str], float]:
        found = super().distances(positions)
        last, distance = found.popitem()
        change = {"distance": 2e-9, "nan": np.nan}.get(self._spoilt, 0.0)
        return found if self._spoilt == "pair" else found | {last: distance + change}

    def hand_pose(self, positions: Array) -> tuple[Array, Array]:
        place, rotation = super().hand_pose(positions)
        return place + 2e-9 * (self._spoilt == "pose"), rotation


def test_only_engines_that_agree_pass_the_gate() -> None:
    found = gate(baked(), {"itself": Wrong("nothing")})["itself"]
    assert found["distance"] == found["hand_pose"] == 0.0
    pair = "left hand / right hand is a pair"
    for spoilt, named in {
        "distance": "distance of it",
        "nan": "distance of it",
        "pose": "hand pose of it",
        "pair": pair,
    }.items():
        with pytest.raises(DuetError, match=named):
            gate(baked(), {"it": Wrong(spoilt)})


@needs_extra
@pytest.mark.parametrize("rig", ["torso", "table"])
def test_the_engines_agree_overlaps_included(rig: str) -> None:
    hold = bake(changed(POSE, "rig", rig), 2)
    # Only installed ones: embodik and roboplan are not available for every machine.
    methods = {name: import_module(f"tests.tools.bench.peer_{name}").METHODS for name in peers.peer_names()}
    agreement = gate(hold, {name: next(iter(made.values()))(hold) for name, made in methods.items()})
    assert all(differences["nearest"] < -0.01 for differences in agreement.values())
    # No pair is silently omitted when the gate compares our distances.
    assert len(Ours(hold).distances(hold.room.start)) == len(hold.room.geometry.collisionPairs) == 15


def test_an_engine_with_different_overlaps_is_detected() -> None:
    pytest.importorskip("roboplan", reason="roboplan is not installed: pip install -e '.[peers]'")
    hold = baked()
    other = import_module("tests.tools.bench.peer_roboplan").RoboPlan(hold)
    other._scene.setCollisions(list(hold.pairs[1:]), False)
    assert peers.disagreement(Ours(hold), other, hold.room)["distance"] > 0.001


@needs_extra
def test_the_mujoco_model_has_our_bounds_and_leaves_the_guided_arm_free() -> None:
    from tests.tools.bench.peer_mink import Mink, matched_gain, mujoco_model

    hold = baked()
    model, ours = mujoco_model(hold), hold.room.model
    assert model.nv == ours.nv == 14 and model.ngeom == len(hold.room.geometry.geometryObjects)
    assert [model.joint(i).name for i in range(14)] == list(ours.names)[1:]
    assert model.jnt_limited[hold.avoiding].all() and not model.jnt_limited[hold.guided].any()
    ranges = np.column_stack([ours.lowerPositionLimit, ours.upperPositionLimit])
    assert np.array_equal(model.jnt_range[hold.avoiding], ranges[hold.avoiding])
    assert matched_gain(0.005) == pytest.approx(2.5e-4)
    # Within its detection distance, mink bounds a step by 10/s times the remaining distance.
    arm = Mink(hold, matched_gain(0.005))
    arm.limit.collision_detection_distance = 10.0
    distances = Ours(hold).distances(hold.room.start)
    bounds = arm.limit.compute_qp_inequalities(arm.configuration, 0.005).h
    assert bounds is not None
    assert np.allclose(sorted(bounds), sorted(10.0 * 0.005 * (d - 0.15) for d in distances.values()))


@pytest.mark.parametrize("pairs", ["single", "soft"])
def test_ours_equals_the_original_run_bit_for_bit(pairs: str) -> None:
    """With the guided arm played back, both arms move as in the run in which a person held it."""
    settings = changed(POSE, "pairs", pairs)
    done = run(settings, 1000 * settings.dt)
    hold = bake(POSE, 1000)
    record = peers.interleaved({"ours": Ours(hold, pairs=pairs)}, hold)["ours"]
    history = done.simulation.history
    assert np.array_equal(record.positions, history.positions(done.table))
    assert np.array_equal(record.velocities, history.velocities(done.table))
    assert np.abs(record.velocities[:, hold.avoiding]).max() > 0.05
    summary = peers.summary(record, hold)
    for name in ("d_min", "share_below", "e2_max", "ddq_max"):
        assert summary[name] == pytest.approx(getattr(done.summary, name), rel=1e-12, abs=1e-15), name


@needs_extra
def test_ours_and_mink_do_the_same_task() -> None:
    """Without obstacles a displaced hand returns along the same line at about the same speed."""
    from tests.tools.bench.peer_mink import Mink, matched_gain

    hold = baked()
    still = replace(hold, guided_positions=hold.guided_positions[:1], guided_velocities=np.zeros((1, 7)))
    q = hold.room.start.copy()
    q[hold.avoiding] += [0.03, -0.02, 0.04, 0.03, -0.05, 0.02, 0.01]
    engine, h = Ours(hold), 1e-6
    place = engine.hand_pose(q)[0]
    wanted = POSE.gain * (hold.place - place)
    # Gain 0 would forbid any approach; a large gain permits all.
    arm = Mink(still, 1.0)
    arm.positions = q.copy()
    arm.prepare(0)
    hand_velocity = (engine.hand_pose(q + h * arm.advance(0))[0] - place) / h
    assert np.linalg.norm(hand_velocity - wanted) < 0.1 * np.linalg.norm(wanted)
    assert matched_gain(POSE.dt) > 0.0


@needs_extra
def test_all_peers_are_measured() -> None:
    """Too short for meaningful times, long enough for all other figures: the arms meet within these steps."""
    result: dict[str, Any] = measure_peers(1000)
    figures = result["figures"]
    assert json.loads(json.dumps(result)) == result
    assert list(figures)[:3] == ["ours, single pair (paper)", "ours, soft minimum", "ours, smooth everywhere"]
    assert len(figures) == 9 + 4 * ("embodik" in peers.peer_names()) + 3 * ("roboplan" in peers.peer_names())
    assert sum("pink" in name for name in figures) == sum("mink" in name for name in figures) == 2
    for name, row in figures.items():
        assert (
            all(np.isfinite(value) for value in row.values())
            and row["median_us"] > 0.0
            and row["unsolved"] == 0.0
        ), name
        assert 0.135 < row["d_min"] < 0.25 and row["e2_max"] > 1e-4 and row["ddq_max"] > 0.0, name
        # Every method gives way, at most 1 mm below d_m; without w embodik and roboplan come closer.
        alone = name.startswith(("embodik", "roboplan")) and "+w" not in name
        assert (row["d_min"] > 0.149) is not alone, name
        if name.startswith("embodik"):
            # No oscillation.
            assert (row["share_below"] > figures["embodik, all pairs +w"]["share_below"]) is alone and row[
                "ddq_max"
            ] < 50.0, name
    assert run(changed(POSE, "law", "unprotected"), 1000 * POSE.dt).summary.d_min < 0.14
    assert figures["ours, single pair (paper)"]["ratio"] == 1.0
    table = peers_table(result)
    assert all(name in table for name in figures) and "1000 steps" in table


def test_a_checkout_without_peers_is_measured_too(monkeypatch: pytest.MonkeyPatch) -> None:
    def installed(name: str) -> str:
        if name == "lwr-duet":
            raise PackageNotFoundError(name)
        return "1.0"

    monkeypatch.setattr("importlib.metadata.version", installed)
    monkeypatch.setattr(peers, "version", installed)
    for name, instead in (
        ("needs_peers", lambda: None),
        ("peer_names", lambda: ()),
        ("gate", lambda *given: {}),
    ):
        monkeypatch.setattr(peers, name, instead)
    result: dict[str, Any] = measure_peers(40)
    assert result["version"] == "0" and result["figures"]


def test_missing_packages_are_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(
        peers, "find_spec", lambda name: None if name in ("pink", "mink") else ModuleSpec(name, None)
    )
    with pytest.raises(BadSetting) as error:
        needs_peers()
    assert (
        "pin-pink, mink" in str(error.value)
        and "mujoco" not in str(error.value)
        and ".[peers]" in str(error.value)
    )
    assert main(["peers", "--steps", "10"]) == 2
    assert capsys.readouterr() == ("", f"bench: {error.value}\n")
    monkeypatch.setattr(peers, "find_spec", lambda name: ModuleSpec(name, None))
    needs_peers()
