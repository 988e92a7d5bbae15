"""The promise on the page: it stands, or the missing condition is named, or the law makes none; and the lever is always shown."""

from typing import get_args

import pytest

from app.lessons.room_places import RoomPlace, Start, start_positions
from app.page.panels.promise_pills import promise_html
from controllers.laws.situation import FIRM_LEVER
from scenes.promise import Condition, missing_now
from scenes.settings import LawName
from scenes.simulation import Simulation
from tests.app.test_readout import played as shared
from tests.app.test_readout import settings, text


def shown(simulation: Simulation) -> str:
    """What the page says of the newest step."""
    return text(promise_html(simulation, simulation.sample()))


def run_until(query: str, condition: Condition, seconds: float = 20.0) -> Simulation:
    """The experiment at the first step that misses nothing but a condition."""
    simulation = Simulation(settings(query).run)
    person = simulation.source()
    while simulation.time < seconds:
        simulation.step(person.target(simulation.time))
        if missing_now(simulation.settings, simulation.history) == (condition,):
            return simulation
    raise AssertionError(f"{query}: {condition} is never missing")


def test_it_stands_in_the_usual_run() -> None:
    near = shared("scene=ball")
    assert shown(near) == "lever s = 1.00d ≥ dlaw ≥ dm stands"
    assert 'class="go"' in promise_html(near, near.sample())
    for scene in ("hold", "master_slave", "imitation"):
        # Far away, where the closest bodies hardly move along the line: the lever is short, and costs nothing.
        assert shown(shared(f"scene={scene}")).endswith("stands")
        assert shown(Simulation(settings(f"scene={scene}").run)).endswith("stands"), "before the first step"
    assert shown(shared("scene=master_slave")).count(", ") == 1, "one lever an arm"
    assert shown(shared("scene=solo")) == ""


def test_a_missing_condition_is_named() -> None:
    fast = run_until("scene=hold&wmax=0.8&v=0.05", Condition.SPEED)
    assert shown(fast).endswith("dm may fail: w > v")
    both = Simulation(settings("scene=imitation&v=0.05").run)
    person = both.source()
    while both.sample().approach <= 0.1:
        both.step(person.target(both.time))
    assert shown(both).endswith("stands"), "the other one keeps clear, too"
    tied = run_until("scene=hold&start=between&avoid=guided&seed=396&v=0.05&pairs=single", Condition.PAIRS)
    assert shown(tied).endswith("dm may fail: between two pairs")


def test_a_short_row_lights_the_lever_with_its_value() -> None:
    """A ball against the elbow, almost along the upper arm."""
    simulation = Simulation(settings("scene=ball&point=elbow&v=0.05").run)
    simulation.reset(start_positions(simulation.room, Start(RoomPlace("elbow", "upper_arm", 0.1, 0.0872665))))
    simulation.step(None)
    sample = simulation.sample()
    assert sample.lever < FIRM_LEVER
    html = promise_html(simulation, sample)
    assert text(html).startswith(f"lever s = {sample.lever:.2f}")
    assert text(html).endswith(f"dm may fail: no lever (s = {sample.lever:.2f})")
    assert 'class="halt"' in html and 'class="alarm"' in html


def test_a_joint_at_its_limit_is_named() -> None:
    simulation = run_until("scene=hold&v=1.0&wmax=1.0&dm=0.3", Condition.BOUND)
    joint = simulation.joint_label(simulation.sample().joint)
    assert shown(simulation).endswith(f"dm may fail: {joint} at its limit")


@pytest.mark.parametrize("law", get_args(LawName)[1:])
def test_a_law_without_the_promise_says_so(law: LawName) -> None:
    assert shown(shared(f"scene=hold&law={law}", 0.1)).endswith("this law does not promise d ≥ dlaw ≥ dm")


def test_a_law_of_your_own_promises_nothing() -> None:
    simulation = shared("scene=hold")
    assert "does not promise" in text(promise_html(simulation, simulation.sample(), custom=True))


def test_a_distance_that_was_lost_is_not_said_to_be_kept() -> None:
    simulation = Simulation(settings("scene=hold&start=between&avoid=guided&seed=396&v=0.05&pairs=single").run)
    person = simulation.source()
    while simulation.sample().law_distance > 0.1 or missing_now(simulation.settings, simulation.history):
        assert simulation.time < 20.0
        simulation.step(person.target(simulation.time))
    assert shown(simulation).endswith("below dm, but d falls no further: every condition is met")
