"""The setting `world`: arms glide along table, stand, floor and their own links."""

from functools import cache

import numpy as np
import pytest

from controllers import compiled
from controllers.first_tasks.links_over_boxes import LinksOverBoxes
from controllers.first_tasks.own_links import OwnLinks
from controllers.first_tasks.several_at_once import SeveralAtOnce
from controllers.first_tasks.surroundings import Surroundings
from controllers.kinematics import Array
from controllers.limits import Authority
from controllers.row_stage import smooth_stage
from scenes.furniture import (
    BENCH_HALF_DEPTH,
    BENCH_TOP,
    TORSO_BLOCK,
    TORSO_COLUMN,
    bench_half_length,
    furniture_of,
)
from scenes.history import COLUMN
from scenes.own_pairs import own_pairs
from scenes.promise import Condition, broken_by, missing
from scenes.rigs import RIGS, TABLE_SEPARATION
from scenes.room_shells import table_meshes, torso_meshes
from scenes.settings import LATER, RigName, RunSettings, changed, named_values, values
from scenes.simulation import Simulation
from scenes.surroundings import MARGIN, TOUCHING, _add_columns, surroundings
from scenes.targets import HandTarget, LinkTarget
from scenes.world_stages import ORDER, WorldStage
from tests.scenes.helpers import given_settings, inside_limits, moved

FAR = {"table": np.array([0.3, 0.25, 0.3]), "torso": np.array([-0.05, 0.0, 0.75])}
"""Targets below the bench, and inside the torso (3,) [m]."""


@pytest.fixture(autouse=True, scope="module")
def machine_code() -> None:
    compiled.load_now()


def task_of(simulation: Simulation, side: int) -> Surroundings:
    task = surroundings(simulation.world, simulation.room.arms[side])
    assert task is not None
    return task


@cache
def dragged(scene: str, rig: RigName, world: bool, link: bool = False) -> tuple[Simulation, float, float]:
    """A run with the guided arm dragged into obstacles; least distances of both arms, guided first [m]."""
    simulation = Simulation(given_settings(scene=scene, rig=rig, world=world, wmax=0.5))
    tasks = [task_of(simulation, side) for side in (1, 0)]
    target = LinkTarget(5, np.zeros(3), FAR[rig]) if link else HandTarget(FAR[rig])
    guided = other = np.inf
    for _ in range(1000):
        simulation.step(target)
        simulation.kinematics.update(simulation.positions)
        guided, other = min(guided, tasks[0].margin().value), min(other, tasks[1].margin().value)
        assert inside_limits(simulation)
    return simulation, guided, other


@pytest.mark.parametrize("rig", ["table", "torso"])
@pytest.mark.parametrize("link", [False, True])
def test_a_dragged_arm_stops_at_obstacles(rig: RigName, link: bool) -> None:
    assert dragged("hold", rig, False, link)[1] < -0.02
    assert dragged("hold", rig, True, link)[1] > 0.95 * MARGIN


def test_master_and_slave_stop_at_the_table_together() -> None:
    without, with_world = dragged("master_slave", "table", False), dragged("master_slave", "table", True)
    assert max(without[1:]) < -0.02
    assert min(with_world[1:]) > 0.95 * MARGIN


def test_an_arm_pressed_against_obstacles_reports_it_and_keeps_the_promise() -> None:
    simulation, *_ = dragged("master_slave", "table", True)
    settings, table = simulation.settings, simulation.history.table()
    pressed = missing(settings, table)[Condition.WORLD]
    said = (table[:, [COLUMN["authority"], COLUMN["authority_b"]]] == Authority.WORLD).any(axis=1)
    assert (pressed == said).all()
    assert broken_by(settings, table) < 1e-4
    off, *_ = dragged("master_slave", "table", False)
    assert not missing(off.settings, off.history.table())[Condition.WORLD].any()


@pytest.mark.parametrize("scene", ["solo", "ball", "hold", "master_slave", "imitation"])
@pytest.mark.parametrize("rig", ["torso", "table"])
def test_world_changes_q_of_autopilot_runs_by_less_than_1e_4_rad(scene: str, rig: RigName) -> None:
    ways: list[Array] = []
    for world in (False, True):
        simulation = moved(given_settings(scene=scene, rig=rig, world=world), lambda run: run.time > 6.0)
        ways.append(simulation.history.positions(simulation.history.table()))
    assert np.abs(ways[1] - ways[0]).max() < 1e-4


def test_world_is_off_by_default_and_then_not_in_tables() -> None:
    settings = RunSettings()
    assert not settings.world and LATER["world"] is settings.world
    assert "world" in values(settings) and "world" not in named_values(settings)
    assert named_values(changed(settings, "world", "on"))["world"] is True


def test_a_run_resumed_from_a_snapshot_has_the_same_bits() -> None:
    whole = Simulation(given_settings(rig="table", world=True, wmax=0.5))
    for _ in range(250):
        whole.step(HandTarget(FAR["table"]))
    snapshot = whole.snapshot()
    for _ in range(150):
        whole.step(HandTarget(FAR["table"]))
    again = Simulation(snapshot.settings)
    again.resume(snapshot)
    for _ in range(150):
        again.step(HandTarget(FAR["table"]))
    assert again.positions.tobytes() == whole.positions.tobytes()


def test_world_chosen_inside_the_table_moves_the_arm_out() -> None:
    simulation = Simulation(given_settings(rig="table", wmax=0.5))
    task = task_of(simulation, 1)
    while simulation.kinematics.update(simulation.positions) or task.margin().value > -0.03:
        simulation.step(HandTarget(FAR["table"]))
    simulation.apply(changed(simulation.settings, "world", True))
    for _ in range(600):
        simulation.step(HandTarget(FAR["table"]))
        assert inside_limits(simulation)
    simulation.kinematics.update(simulation.positions)
    assert task.margin().value > 0.95 * MARGIN
    simulation.apply(changed(simulation.settings, "world", False))
    for _ in range(200):
        simulation.step(HandTarget(FAR["table"]))
    simulation.kinematics.update(simulation.positions)
    assert task.margin().value < 0.0


def test_the_guided_arm_uses_true_positions_despite_bad_sensors() -> None:
    simulation = Simulation(given_settings(rig="table", world=True, wmax=0.5, fps=20.0, dead=0.02))
    task, least = task_of(simulation, 1), np.inf
    for _ in range(600):
        simulation.step(HandTarget(FAR["table"]))
        simulation.kinematics.update(simulation.positions)
        least = min(least, task.margin().value)
    assert least > 0.95 * MARGIN


def test_the_furniture_matches_the_drawn_one() -> None:
    bench = table_meshes(TABLE_SEPARATION, 2, False)["light"].bounds
    half = bench_half_length(TABLE_SEPARATION)
    np.testing.assert_allclose(bench[1], [half, BENCH_HALF_DEPTH, BENCH_TOP], atol=1e-9)
    np.testing.assert_allclose(bench[0, :2], [-half, -BENCH_HALF_DEPTH], atol=1e-9)
    box = furniture_of(RIGS["table"]).boxes[1]
    np.testing.assert_allclose(box[:3] + box[3:], bench[1], atol=1e-9)
    drawn = torso_meshes(False)["dark"].vertices
    column = drawn[(drawn[:, 2] > 0.15) & (np.hypot(drawn[:, 0] - TORSO_BLOCK[0], drawn[:, 1]) < 0.09)]
    assert (
        np.hypot(column[:, 0] - TORSO_BLOCK[0], column[:, 1])[column[:, 2] < 0.78].max()
        <= TORSO_COLUMN + 1e-9
    )


@pytest.mark.parametrize("robot", ["lwr", "panda", "ur5"])
@pytest.mark.parametrize("rig", ["torso", "table"])
def test_every_arm_starts_clear(rig: RigName, robot: str) -> None:
    simulation = Simulation(given_settings(rig=rig, robot=robot))
    for side in (0, 1):
        assert task_of(simulation, side).margin().value > 2.0 * MARGIN


def test_the_torso_is_paired_with_the_links_that_can_meet_it() -> None:
    simulation = Simulation(given_settings(rig="torso"))
    task = task_of(simulation, 1)
    pairs = {(task.names[one.first], task.names[one.second]) for one in task.meetings if not one.over_box}
    over = {task.names[one.first] for one in task.meetings if one.over_box}
    assert {("pedestal", "hand"), ("hand", "stand 0"), ("forearm", "stand 1")} <= pairs
    assert {"forearm", "hand"} <= over and not any("stand" in name or "pedestal" in name for name in over)


def postures(simulation: Simulation, side: int, count: int) -> Array:
    joints, model = simulation.room.arms[side].joints, simulation.room.model
    low, high = model.lowerPositionLimit[joints], model.upperPositionLimit[joints]
    return np.random.default_rng(3).uniform(low, high, (count, len(low)))


@pytest.mark.parametrize("rig", ["torso", "table"])
def test_one_loop_is_the_smooth_minimum_of_own_links_and_boxes(rig: RigName) -> None:
    simulation = Simulation(given_settings(rig=rig))
    world, arm = simulation.world, simulation.room.arms[1]
    task, furniture = task_of(simulation, 1), furniture_of(simulation.room.rig)
    geometry = own_pairs(simulation.room, arm, TOUCHING)
    _add_columns(simulation.room, geometry, furniture.columns)
    over = sorted({one.first for one in task.meetings if one.over_box})
    links = LinksOverBoxes(world.kinematics, arm, [task.capsules[k] for k in over], furniture.boxes)
    both = SeveralAtOnce([OwnLinks(world.kinematics, arm, geometry, 0.03, 0.05), links], "both", 3.0)
    for q in postures(simulation, 1, 300):
        simulation.positions[arm.joints] = q
        simulation.world.update()
        one, other = task.margin(), both.margin()
        assert one.value == pytest.approx(other.value, abs=1e-9)
        np.testing.assert_allclose(one.row, other.row, atol=1e-7)


def test_a_stage_is_the_one_sided_law_of_the_paper_with_joint_bounds() -> None:
    simulation = Simulation(given_settings(rig="table"))
    arm, random = simulation.room.arms[1], np.random.default_rng(4)
    task, box = task_of(simulation, 1), simulation.world.bounds.part(arm.joints)
    stage, expected = WorldStage(task, box), smooth_stage(task, box, ORDER, one_sided=True)
    bounded = unchanged = 0
    for q in postures(simulation, 1, 400):
        simulation.positions[arm.joints] = q
        simulation.world.update()
        wanted = box.clip(random.uniform(-2.0, 2.0, 7))
        kept, by_rule = wanted.copy(), expected(wanted)
        bounded += not task.law(ORDER, box.lower, box.upper)(kept)
        kept[:] = wanted
        stage.keep(kept)
        unchanged += bool((kept == wanted).all())
        np.testing.assert_allclose(kept, by_rule, atol=1e-12)
        assert box.contains(kept)
    assert bounded > 5 and 20 < unchanged < 380
