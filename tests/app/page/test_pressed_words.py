"""The promise's lamp names the thing that an arm is pressed against, in runs of a person who presses."""

from collections import Counter

import numpy as np
import pytest

from app.page.panels.contact_card import contact_note
from app.page.panels.distance_rate import PRESSED, budget_terms, promise_words
from app.session.frame import contact
from controllers import compiled
from controllers.limits import Authority
from scenes.rigs import place_bases
from scenes.settings import changed
from scenes.simulation import Simulation
from scenes.targets import HandTarget
from tests.scenes.helpers import given_settings

STEPS = 400
"""Steps of a run that drags the orange hand to a place behind the silver arm."""

CASES: dict[str, tuple[str, tuple[float, ...], tuple[float, ...]]] = {
    "table": ("table", (1.22, -1.39, -0.93, 1.68, 2.49, 1.86, -2.44), (-0.12, 0.26, 0.74)),
    "floor": ("low", (-1.0, -1.78, -2.16, -0.64, -2.16, -1.8, 1.45), (0.08, -0.46, 0.0)),
    "stand": ("torso", (1.77, 1.86, -0.61, -1.4, -2.15, -1.67, 1.41), (0.03, -0.01, 0.63)),
    "pedestal": ("torso", (-2.41, -1.45, -0.53, 1.81, 0.26, -1.77, -0.72), (0.08, 0.08, 0.95)),
    "itself": ("table", (-0.13, -0.72, 0.28, 1.87, 0.72, -1.87, 2.61), (-0.36, 0.01, 1.18)),
}
"""Thing → rig, posture of the silver arm near that thing [rad], and a place on the thing [m]."""


@pytest.fixture(autouse=True, scope="module")
def machine_code() -> None:
    compiled.load_now()


def made(thing: str, world: bool) -> tuple[Simulation, HandTarget]:
    """A run before its first step, and the person's target."""
    rig, posture, place = CASES[thing]
    name = place_bases("-0.45,0,0.1,0", "0.45,0,0.1,180") if rig == "low" else rig
    settings = changed(given_settings(scene="hold", world=world, wmax=0.5), "rig", name)
    simulation = Simulation(settings)
    start = simulation.positions.copy()
    start[simulation.avoiding.joints] = posture
    simulation.reset(start)
    return simulation, HandTarget(np.array(place))


def named(simulation: Simulation, target: HandTarget) -> Counter[str]:
    """Number of steps at which the lamp names each thing."""
    said: Counter[str] = Counter()
    for _ in range(STEPS):
        simulation.step(target)
        simulation.kinematics.update(simulation.positions)
        kind, words = promise_words(simulation, simulation.sample())
        for thing, text in PRESSED.items():
            if text in words:
                assert kind == "alarm"
                said[thing or ""] += 1
    return said


@pytest.mark.parametrize("thing", CASES)
def test_the_lamp_names_the_thing_the_silver_arm_is_pressed_against(thing: str, registry: None) -> None:
    said = named(*made(thing, True))
    assert said[thing] > 40 and said[thing] == max(said.values())
    assert "" not in said
    assert not named(*made(thing, False))


def test_the_card_names_it_too() -> None:
    simulation, target = made("table", True)
    simulation.step(target)
    while simulation.sample().authority != Authority.WORLD:
        simulation.step(target)
    sample = simulation.sample()
    now = contact(simulation, sample)
    kind, words = contact_note(simulation, sample, now, budget_terms(simulation, sample, now))
    assert kind == "alarm" and "pressed against the table" in words


def test_the_lamp_names_the_thing_the_persons_arm_is_pressed_against() -> None:
    settings = given_settings(scene="hold", rig="torso", avoid="both", world=True, wmax=0.5)
    simulation, said = Simulation(settings), Counter[str]()
    joint, way = simulation.avoiding.joints.start + 5, np.array([0.077, 0.271, -0.804])
    for _ in range(900):
        simulation.step(HandTarget(simulation.kinematics.joint_point(joint) + 0.15 * way))
        second = simulation.sample().second
        assert second is not None
        if second.authority == Authority.WORLD:
            simulation.kinematics.update(simulation.positions)
            said[promise_words(simulation, simulation.sample())[1].split(": ")[-1]] += 1
    assert said["pressed against the stand"] > 100
