"""Other first tasks, without a browser: the chooser, the wall with its handle, words and units."""

import html
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from app.page.panels.contact_card import contact_note, contact_words, symbol_sentences
from app.page.panels.distance_rate import budget_terms, promise_html, promise_words
from app.page.panels.readout import status_html
from app.page.panels.scene_words import scene_sentence
from app.plots.time_plots import time_plot_of
from app.session.frame import Frame, freeze
from app.session.session import Session
from app.settings import Settings, from_query, to_query
from app.text.first_task_texts import in_unit, said_of
from app.text.law_texts import equation_html
from app.text.lever_texts import lever_text
from controllers.limits import Authority
from scenes.laws import LAWS
from scenes.quantities import ALL, FIRST_TASKS, PARTS, STOPS, TIP, WALL, quantity_of_pair
from scenes.settings import LawSettings, RunSettings, specs
from scenes.simulation import Simulation
from scenes.targets import WallTarget
from tests.app.conftest import Arrive, OpenHouse
from tests.app.page.helpers import page_label
from tests.approved import Approve, case_lines, shown_text, without_numbers


def frame_of(first: str, **others: Any) -> Frame:
    simulation = Simulation(RunSettings(scene="first_task", first=first, **others))
    source = simulation.source()
    for _ in range(300):
        simulation.step(source.target(simulation.time))
    frame = freeze(Session(Settings(simulation.settings)), 0.0)
    return replace(frame, simulation=simulation, sample=simulation.sample())


def status_of(simulation: Simulation) -> str:
    """Text of the status next to the clock."""
    said = status_html(freeze(Session(Settings()), 0.0).pace, simulation, simulation.sample())
    return " · ".join(shown_text(said).splitlines())


def test_the_card_promises_nothing_if_no_joint_changes_the_value() -> None:
    frame = frame_of(TIP)
    terms = budget_terms(frame.simulation, frame.sample, frame.contact)
    assert promise_words(frame.simulation, frame.sample)[0] == "go"
    kind, _ = contact_note(frame.simulation, frame.sample, frame.contact, terms)
    assert kind == ""


@pytest.mark.parametrize("first", FIRST_TASKS)
def test_card_plot_equation_and_sliders_have_its_symbol_and_unit(first: str) -> None:
    frame, kept = frame_of(first), FIRST_TASKS[first]
    run, least = frame.simulation.settings, quantity_of_pair(kept, frame.sample.pair)
    terms = budget_terms(frame.simulation, frame.sample, frame.contact)
    words = contact_words(frame, terms)
    assert str(words["apart"]).startswith(f"{least.page_unit} ") and words["symbol"] == kept.symbol
    assert promise_words(frame.simulation, frame.sample)[1].startswith(
        f"{kept.symbol} ≥ {kept.symbol}<sub>m</sub>"
    )
    assert symbol_sentences(frame)["dm"].startswith(f"{kept.symbol}_m: ")
    plot = time_plot_of("distance", frame.simulation)
    assert (
        plot.unit == kept.unit
        and kept.short in plot.title
        and plot.lines[1].name == f"{kept.symbol}<sub>m</sub>"
    )
    assert time_plot_of("speeds", frame.simulation).unit == kept.rate_unit
    title = in_unit(specs()["dm"], kept).title(said_of(kept))
    assert title.endswith(f"{kept.symbol}_m [{kept.page_unit}]")
    assert in_unit(specs()["v"], kept).page_unit == kept.rate_unit
    assert f"{kept.symbol} = " in scene_sentence(frame) and f" {least.page_unit};" in scene_sentence(frame)
    strict = replace(run, law=replace(run.law, law="strict_switched", pairs="single"))
    assert ("sigma ≤ sigma" in equation_html(strict)) == (first == "singular")


@pytest.mark.parametrize("first", FIRST_TASKS)
def test_a_value_has_no_point_and_no_gap(first: str) -> None:
    frame, has_point = frame_of(first), bool(FIRST_TASKS[first].against)
    for lever in (0.05, 0.5):
        weak = replace(frame.sample, lever=lever, activation=0.5, authority=Authority.LEVERAGE)
        said = str(status_html(frame.pace, frame.simulation, weak)) + promise_html(frame.simulation, weak)
        assert ("this point" in said) == has_point and ("this value" in said) == (not has_point)
        assert lever_text(lever, FIRST_TASKS[first]) in said
    terms = budget_terms(frame.simulation, frame.sample, frame.contact)
    words, sentences = contact_words(frame, terms), symbol_sentences(frame)
    assert words["ways"] == (["closes", "opens"] if has_point else ["falls", "rises"])
    assert ("gap" in sentences["u"]) == ("comes nearer" in sentences["w"]) == has_point
    symbol = FIRST_TASKS[first].symbol
    assert sentences["rest"].startswith(f"{symbol}*: at this {'distance' if has_point else 'value'}")
    assert sentences["law"].startswith(f"{symbol}_law: ")
    rates = time_plot_of("speeds", frame.simulation).title
    assert rates == ("speeds along the line" if has_point else "rates of the first task")


def test_with_all_first_tasks_the_least_gives_words_and_unit() -> None:
    frame = frame_of(ALL)
    terms = budget_terms(frame.simulation, frame.sample, frame.contact)
    said: list[tuple[object, object]] = []
    for pair in range(len(PARTS[ALL])):
        words = contact_words(replace(frame, sample=replace(frame.sample, pair=pair)), terms)
        said.append((words["apart"], words["mm"]))
    assert said == [
        ("mm to the wall", "mm"),
        ("mm/rad from singular", "mm/rad"),
        ("mrad to the joint stops", "mrad"),
        ("mm inside the foot", "mm"),
    ]


@pytest.mark.parametrize("law", LAWS)
def test_no_law_mentions_d_or_arms_if_the_value_is_an_angle(law: str) -> None:
    frame = frame_of(STOPS, law=LawSettings(law=law, pairs="single"))
    terms = budget_terms(frame.simulation, frame.sample, frame.contact)
    note = contact_note(frame.simulation, frame.sample, frame.contact, terms)[1]
    pills = promise_html(frame.simulation, frame.sample)
    symbols = " ".join(term.symbol for term in terms)
    status = status_html(frame.pace, frame.simulation, frame.sample)
    said = re.sub(r"<[^>]+>", "", html.unescape(f"{note} {pills} {symbols} {status}"))
    assert said.strip()
    assert not re.search(r"\bd\b|\bdm\b|Jd|\barms?\b(?! cannot)|m/s|gap|distance|them", said), said


def test_the_hints_of_threshold_and_speed_are_about_the_value() -> None:
    stops, wall = FIRST_TASKS[STOPS], FIRST_TASKS[WALL]
    assert in_unit(specs()["dm"], stops).help.startswith("Critical value")
    assert in_unit(specs()["v"], stops).help.endswith("the value rises.")
    assert in_unit(specs()["dm"], wall).help == specs()["dm"].help


def test_a_threshold_above_the_start_value_is_reported() -> None:
    simulation = Simulation(
        RunSettings(scene="first_task", first="tip", law=LawSettings(critical_distance=0.25))
    )
    said = html.unescape(status_html(freeze(Session(Settings()), 0.0).pace, simulation, simulation.sample()))
    assert "take a smaller h_m" in said
    simulation.apply(replace(simulation.settings, law=LawSettings()))
    assert "smaller" not in status_html(
        freeze(Session(Settings()), 0.0).pace, simulation, simulation.sample()
    )


def test_a_wall_stopped_before_the_base_is_reported() -> None:
    simulation = Simulation(RunSettings(scene="first_task", first="wall"))
    for _ in range(900):
        simulation.step(WallTarget(np.array([-2.0, 0.0, 1.4]), np.zeros(2)))
    assert status_of(simulation) != status_of(Simulation(simulation.settings))


def test_texts_of_first_tasks(approve: Approve) -> None:
    tipping = Simulation(
        RunSettings(scene="first_task", first="tip", law=LawSettings(critical_distance=0.25))
    )
    stopped = Simulation(RunSettings(scene="first_task", first="wall"))
    for _ in range(900):
        stopped.step(WallTarget(np.array([-2.0, 0.0, 1.4]), np.zeros(2)))
    frame = frame_of(TIP)
    terms = budget_terms(frame.simulation, frame.sample, frame.contact)
    said = {
        "more than the start has": without_numbers(status_of(tipping)),
        "wall before the base": without_numbers(status_of(stopped)),
        "unchanged value": contact_note(frame.simulation, frame.sample, frame.contact, terms)[1],
    }
    approve("first tasks.txt", case_lines(said))


def test_a_link_opens_a_first_task_with_its_choices() -> None:
    settings, problems = from_query(
        {"scene": "first_task", "first": "all", "together": "stages", "load": "3"}, Settings()
    )
    assert not problems
    assert settings.run == RunSettings(scene="first_task", first="all", together="stages", load=3.0)
    assert from_query(to_query(settings), Settings())[0] == settings


def test_a_visitor_chooses_a_first_task_and_drags_and_turns_the_wall(
    house: OpenHouse, arrive: Arrive
) -> None:
    one = arrive(house(), "scene=first_task&autopilot=0&speed=2")
    one.visitor.wait_for(lambda v: {"/wall", "/kept_from_wall", "/gizmo/wall"} <= set(v.mirror.nodes))
    chooser = one.visitor.mirror.labelled(page_label("first"))
    assert chooser["visible"] and len(chooser["options"]) == len(FIRST_TASKS)
    c, s = np.cos(0.2), np.sin(0.2)
    goal = np.array([0.15, 0.1, 1.35])
    one.visitor.move_gizmo("/gizmo/wall", phase="start")
    one.visitor.move_gizmo("/gizmo/wall", tuple(goal.tolist()), wxyz=(float(c), 0.0, 0.0, float(s)))
    one.wait(lambda x: isinstance(x.held, WallTarget))
    one.visitor.wait_for(
        lambda v: np.linalg.norm(np.array(v.mirror.nodes["/wall"]["position"]) - goal) < 0.03
    )
    one.wait(lambda x: abs(x.simulation.positions[x.simulation.room.wall][3] - 0.4) < 0.05)
    one.visitor.move_gizmo("/gizmo/wall", phase="end")
    one.wait(lambda x: x.held is None)
    one.visitor.set_value(page_label("first"), FIRST_TASKS["tip"].label)
    one.wait(lambda x: x.settings.run.first == "tip" and x.simulation.room.wall is None)
    one.visitor.wait_for(
        lambda v: (
            "/wall" not in v.mirror.nodes and {"/balance/centre", "/balance/foot"} <= set(v.mirror.nodes)
        )
    )
    one.visitor.wait_for(lambda v: v.mirror.labelled(page_label("load"))["visible"])
