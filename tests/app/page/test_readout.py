"""Numbers and words agree with the simulation, in every experiment and under every law."""

import math
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from functools import cache
from html import unescape

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.page.panels.contact_card import contact_note
from app.page.panels.distance_rate import (
    MISSED,
    Term,
    budget_terms,
    error_step,
    missed,
    promise_html,
    wanted_rate,
)
from app.page.panels.readout import error_html, status_html, tiles_html, tip_text
from app.plots.stability_text import section_html, task_error
from app.plots.time_series import Swivel
from app.session.clock import Clock, Pace
from app.session.frame import Contact, contact
from app.session.session import Session
from app.settings import Settings, from_query
from app.text.law_texts import LAW_TEXTS, equation_html, equation_of
from controllers.laws.situation import AUTHORITY
from controllers.limits import Authority
from controllers.stability import analyse
from scenes.experiments import EXPERIMENTS
from scenes.history import Sample
from scenes.law_answers import LawAnswers, ReplayedLaw
from scenes.laws import LAWS
from scenes.promise import Condition, missing_now
from scenes.rigs import MIRROR
from scenes.simulation import Simulation
from scenes.solo import build_alone
from tests.approved import Approve, case_lines
from tests.scenes.helpers import moved

SCENES = tuple(EXPERIMENTS)
RUNNING = Pace(False, 1.0, False)


def settings(query: str) -> Settings:
    made, problems = from_query(dict(part.split("=") for part in query.split("&")), Settings())
    assert not problems
    return made


@cache
def played(query: str, seconds: float = 1.0) -> Simulation:
    """An experiment after some seconds with its own person. Shared: do not step it."""
    return moved(settings(query).run, lambda simulation: simulation.time >= seconds)


def seen(query: str, seconds: float = 1.0) -> tuple[Simulation, Sample, Contact]:
    """A played experiment with its newest sample and its contact."""
    simulation = played(query, seconds)
    sample = simulation.sample()
    return simulation, sample, contact(simulation, sample)


def text(html: str) -> str:
    return unescape(re.sub(r"<[^>]+>", "", str(html))).replace("\u00a0", " ")


def parts(html: str) -> str:
    """Text with a dot between the elements."""
    return text(re.sub(r"(</(span|div|p)>)+", " · ", str(html))).strip(" ·")


def shares(terms: list[Term]) -> str:
    """Terms that open and close the gap, as a formula."""
    return " ".join(
        f"{'−' if term.kind in ('u', 'w') else '+'}{text(term.symbol)}"
        for term in terms
        if term.kind != "lost"
    )


VARIANTS = ("", "&avoid=both", "&avoid=both&coupled=1", "&avoid=guided", "&ff=1", "&pairs=single")


LEAVES_SOME = ("null_space_avoidance", "barrier_qp", "task_activation", "continuous_inverse")
"""Laws with a distance rate that may differ from their line's, because of the hand or another pair."""


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("scene", ["ball", "hold", "master_slave", "imitation"])
def test_the_budget_equals_the_distance_rate(scene: str, law: str) -> None:
    """ḋ of the law's line equals ḋ of J_d and q̇, and so does the sum on the page."""
    for variant in VARIANTS:
        # No other test uses these runs, so they are not cached.
        simulation = moved(
            settings(f"scene={scene}&law={law}&dm=0.2&n=2&d0=0.5&v=0.2{variant}").run, lambda s: s.time >= 1.0
        )
        sample = simulation.sample()
        now = contact(simulation, sample)
        rate = wanted_rate(simulation, sample, now)
        terms = budget_terms(simulation, sample, now)
        assert sum(term.value for term in terms) == pytest.approx(now.change, abs=MISSED)
        lost = sum(term.value for term in terms if term.kind == "lost")
        assert sum(term.value for term in terms) - lost == pytest.approx(rate, abs=1e-9), variant
        levers = [now.square] if sample.second is None else [now.square, now.second_square]
        if min(levers) < AUTHORITY**2 or simulation.bound_bites or law in LEAVES_SOME:
            continue
        assert now.change == pytest.approx(rate, abs=1e-9) and lost == 0.0, variant
        if sample.second is not None:
            lam, both = sample.activation, sample.pull + sample.second.pull
            if law == "smooth_priority":
                assert shares(terms) == "−(1−λ)(u1+u2) +2λv"
                assert rate == pytest.approx(2.0 * lam * 0.2 - (1.0 - lam) * both, abs=1e-12)
        else:
            assert now.rate == pytest.approx(
                simulation.law.line_rate(now.distance, now.pull, now.approach, now.square), abs=1e-9
            )


def test_the_missed_part_of_a_laws_rate_is_shown_with_its_reason() -> None:
    simulation, sample, now = seen("scene=hold&law=null_space_avoidance&dm=0.3&d0=0.6")
    (lost,) = [term for term in budget_terms(simulation, sample, now) if term.kind == "lost"]
    assert (
        lost.value == pytest.approx(now.change - wanted_rate(simulation, sample, now))
        and abs(lost.value) > MISSED
    )
    assert missed(simulation, sample) == "the hand comes first"
    assert not [
        term for term in budget_terms(*seen("scene=hold&dm=0.05")) if term.kind == "lost" and term.value
    ]
    assert shares(budget_terms(*seen("scene=hold&ff=1"))) == "−w −(1−λ)u +λ(v+w)"
    assert shares(budget_terms(*seen("scene=hold&law=barrier_qp"))) == "−w −u +c"


@pytest.mark.parametrize("activation", [0.0, 1.0])
def test_symbol_and_number_of_a_switch_match(activation: float) -> None:
    def reached(simulation: Simulation) -> bool:
        sample = simulation.sample()
        return sample.activation == activation and sample.pull > 0.05

    simulation = moved(settings("scene=ball&law=strict_switched&v=0.2&dm=0.3").run, reached)
    sample = simulation.sample()
    terms = {term.kind: term for term in budget_terms(simulation, sample, contact(simulation, sample))}
    assert shares(list(terms.values())) == "−w −(1−λ)u +λv" and LAW_TEXTS["strict_switched"].share.endswith(
        "λ"
    )
    assert terms["u"].value == pytest.approx(-(1.0 - activation) * sample.pull)
    assert terms["v"].value == pytest.approx(activation * 0.2)


GAINS = ("k=0", "k=2", "k=20&kx=10&dt=0.005", "k=20&kx=10&dt=0.02")


def test_the_single_arm_explains_k_dt(approve: Approve) -> None:
    alone = {query: settings(f"scene=solo&path=circle&{query}").run for query in GAINS}
    approve("error steps.txt", case_lines({query: text(error_step(run)) for query, run in alone.items()}))


@pytest.mark.parametrize("query", GAINS)
def test_the_single_arm_is_called_unstable_only_if_it_is(query: str) -> None:
    simulation, sample, _ = seen(f"scene=solo&path=circle&{query}", 0.1)
    unstable = simulation.settings.gain * simulation.settings.overdrive * simulation.settings.dt >= 2.0
    assert ("unstable" in status_html(RUNNING, simulation, sample)) == unstable
    assert ('class="bad"' in tiles_html(simulation, sample)) == unstable


def tile_values(html: str) -> list[str]:
    return [text(part).replace("−", "-") for part in re.findall(r"<b class=\"\w+\">(.*?)</b>", html)]


@pytest.mark.parametrize("scene", SCENES)
def test_the_error_of_every_experiment(scene: str) -> None:
    simulation, sample, _ = seen(f"scene={scene}")
    tiles = tile_values(tiles_html(simulation, sample))
    if scene == "solo":
        assert len(tiles) == 4 and error_html(simulation, sample) == ""
        assert float(tiles[0]) == pytest.approx(1000.0 * sample.error, abs=0.06) and float(tiles[1]) == 4.0
        return
    assert tiles == []
    errors = (
        [sample.error] if sample.second is None else [sample.error, math.sqrt(sample.second.squared_error)]
    )
    words = text(error_html(simulation, sample))
    shown = [float(number) for number in re.findall(r"[\d.]+", words)]
    scale = 180.0 / math.pi if simulation.settings.experiment.error_unit == "rad²" else 1000.0
    expected = sorted(scale * e for e in errors) if scene == "imitation" else [scale * errors[0]]
    assert sorted(shown) == pytest.approx(expected, abs=0.51)
    assert words.endswith("mm") == (simulation.settings.experiment.error_unit == "m²")


@pytest.mark.parametrize(
    ("robot", "task", "free"),
    [
        ("lwr", "position", 4.0),
        ("lwr", "pose", 1.0),
        ("ur5", "position", 3.0),
        ("ur5", "pose", 0.0),
        ("panda", "position", 4.0),
    ],
)
def test_the_trace_of_n_counts_the_joints_left_free_by_the_hand(robot: str, task: str, free: float) -> None:
    simulation = played(f"scene=solo&robot={robot}&task={task}", 0.3)
    assert float(tile_values(tiles_html(simulation, simulation.sample()))[1]) == free


def test_the_ghosts_error_is_shown_next_to_the_runs() -> None:
    own, ghost = played("v=0.1&dm=0.16", 4.5), played("v=0.1&dm=0.16&law=unprotected", 4.5)
    words = text(error_html(own, own.sample(), ghost))
    assert re.fullmatch(r"\|e\| \d+ mm \(ghost \d+ mm\)", words)
    errors = [float(number) for number in re.findall(r"\d+", words)]
    assert errors == [round(1000.0 * one.sample().error) for one in (own, ghost)]
    assert "ghost" not in error_html(own, own.sample())


def test_every_reason_for_missing_authority_of_either_arm_is_named() -> None:
    simulation, sample, _ = seen("scene=master_slave")
    assert sample.second is not None
    first = replace(sample, authority=int(Authority.STOP), joint=3)
    assert text(status_html(RUNNING, simulation, first)).count("near its limit") == 1
    both = replace(first, second=replace(sample.second, authority=int(Authority.SPEED), joint=2))
    words = text(status_html(RUNNING, simulation, both))
    assert "near its limit" in words and "at its top speed" in words
    assert simulation.joint_label(3) in words and simulation.joint_label(2, second=True) in words


def short_lever(lever: float) -> str:
    """Status text at a lever."""
    simulation, sample, _ = seen("scene=master_slave")
    moving = next(
        p for p, names in enumerate(simulation.detector.pair_names) if "pedestal" not in " ".join(names)
    )
    short = replace(sample, authority=int(Authority.LEVERAGE), joint=-1, lever=lever, pair=moving)
    return parts(status_html(RUNNING, simulation, short))


@cache
def bolted() -> Simulation:
    """A run with d_m = 300 mm: the silver arm's nearest body is its pedestal, which no joint moves."""
    return moved(settings("scene=hold&dm=0.3").run, lambda s: s.sample().authority == Authority.LEVERAGE)


def faster(query: str) -> str:
    simulation, sample, _ = seen(query)
    return parts(status_html(RUNNING, simulation, replace(sample, law_approach=0.31)))


def test_the_status_names_the_obstacles_of_the_law(approve: Approve) -> None:
    said = {
        "no lever": short_lever(0.05),
        "short lever": short_lever(0.6),
        "bolted down": parts(status_html(RUNNING, bolted(), bolted().sample())),
        "fast hand": faster("scene=hold"),
        "fast ball": faster("scene=ball"),
    }
    approve("status.txt", case_lines(said))


def test_a_pedestal_within_d_m_is_described_without_jargon() -> None:
    simulation = bolted()
    sample = simulation.sample()
    assert "pedestal" in simulation.detector.pair_names[sample.pair][0]
    words = text(status_html(RUNNING, simulation, sample))
    assert "no joint" not in words and "authority" not in words
    # The card shows no promise then, and the promise has the same reason.
    now = contact(simulation, sample)
    kind, note = contact_note(simulation, sample, now, budget_terms(simulation, sample, now))
    assert kind != "go" and shown(simulation).endswith(text(note))
    assert "no joint" not in promise_html(simulation, sample)
    # Not shown for a body that a joint moves.
    moving = next(p for p, (own, _) in enumerate(simulation.detector.pair_names) if own == "left forearm")
    assert "Bolted" not in status_html(RUNNING, simulation, replace(sample, pair=moving))


def test_a_short_lever_is_not_a_warning_while_lambda_is_zero() -> None:
    simulation, sample, _ = seen("scene=hold")
    far = replace(
        sample, lever=0.4, activation=0.0, distance=0.37, law_distance=0.37, authority=int(Authority.FULL)
    )
    assert 'class="halt"' not in promise_html(simulation, far)
    assert 'class="halt"' in promise_html(simulation, replace(far, activation=0.2))


def test_an_approach_faster_than_v_is_named() -> None:
    for query in ("scene=hold", "scene=ball"):
        simulation, sample, _ = seen(query)
        fast = replace(sample, law_approach=0.31)
        assert "faster" in status_html(RUNNING, simulation, fast)
        for other in (f"{query}&ff=1", f"{query}&law=barrier_qp", f"{query}&law=unprotected"):
            assert "faster" not in status_html(RUNNING, played(other), fast)
    # If both arms avoid, the bound holds for any v > 0.
    simulation, sample, _ = seen("scene=master_slave")
    assert "faster" not in status_html(RUNNING, simulation, replace(sample, law_approach=0.31))


def test_a_paused_run_is_not_called_slowed() -> None:
    clock = Clock(1.0)
    for _ in range(10):
        clock.note(0, 1, 0.5, 0.002)
    assert clock.pace(False).slowed and not clock.pace(True).slowed


VARIED = "&path=circle &ball=cross &point=arm &following=identical &avoid=both &avoid=guided &avoid=free &autopilot=0"


@pytest.mark.parametrize("scene", SCENES)
def test_every_choice_has_a_tip(scene: str) -> None:
    tips = {tip_text(Session(settings(f"scene={scene}{variant}"))) for variant in ("", *VARIED.split())}
    assert all(25 < len(text(tip)) < 170 and tip.endswith(".") for tip in tips) and len(tips) > 1
    # A spectator of a shared session cannot pull anything.
    watched = {
        tip_text(Session(settings(f"scene={scene}{variant}")), operated=False)
        for variant in ("", *VARIED.split())
    }
    assert all(len(text(tip)) > 20 and tip.endswith(".") for tip in watched)
    assert not [
        tip
        for tip in watched
        for word in ("Pull", "pull", "Drag", "drag", "take over", "raise")
        if word in tip
    ]


@pytest.mark.parametrize("law", LAWS)
def test_every_law_has_an_equation_and_a_source(law: str) -> None:
    run = settings(f"law={law}").run
    html = equation_html(run)
    assert LAW_TEXTS[law].source.replace("&", "&") in text(html)
    drawings = re.findall(r"<svg .*?</svg>", html, re.DOTALL)
    assert len(drawings) == len(LAW_TEXTS[law].equation)
    for drawing in drawings:
        root = ET.fromstring(drawing)
        assert float(root.attrib["width"]) < 300.0
        assert sum(element.tag.endswith("path") for element in root.iter()) >= 3
    assert ('class="' in " ".join(drawings)) == (law != "unprotected")
    assert equation_of(settings(f"law={law}&scene=solo").run)[1] == "(4)–(8)"


def test_section_three_mentions_only_its_law(approve: Approve) -> None:
    for law in LAWS:
        words = text(section_html(*seen(f"scene=hold&law={law}")))
        assert ("sym(M)" in words) == (law in ("smooth_priority", "unprotected"))
    for query, shown in (
        ("scene=master_slave", True),
        ("scene=master_slave&coupled=1", False),
        ("scene=ball", True),
    ):
        words = text(section_html(*seen(query)))
        assert ("sym(M)" in words) == shown and ("W" in words and shown) == (shown and "master" in query)
    # Otherwise the row would be of one arm and the Jacobian of the other, which may have fewer joints.
    assert "keeps clear" in text(section_html(*seen("scene=hold&robot=lwr_ur5&avoid=guided")))
    simulation = moved(settings("scene=hold").run, lambda s: s.time >= 1.0)
    sample = simulation.sample()
    now = contact(simulation, sample)
    simulation.use(ReplayedLaw([LawAnswers("mine.py", "0" * 64, np.zeros((1, 8)))], simulation, 0))
    approve("section.txt", text(section_html(simulation, sample, now)) + "\n")


@pytest.mark.parametrize(
    "query", ["scene=hold", "scene=hold&task=pose", "scene=master_slave", "scene=ball&point=elbow"]
)
def test_section_three_shows_the_current_step(query: str) -> None:
    simulation, sample, now = seen(query, 4.0)
    error, J = task_error(simulation, sample)
    position = error if J is None else error[:3]
    assert float(position.dot(position)) == pytest.approx(sample.squared_error, rel=1e-9, abs=1e-12)
    # In the law's terms: u = −J_d q̇_n.
    run = simulation.settings
    analysis = analyse(now.row, J, sample.activation, run.gain, run.gain, damped=True)
    least = f"{analysis.smallest_eigenvalue:+.2f}".replace("-", "−")
    assert least in text(section_html(simulation, sample, now)) or abs(analysis.smallest_eigenvalue) < 0.005


def test_the_numbers_do_not_change_the_run() -> None:
    query = "scene=hold&dm=0.25&pairs=soft"
    watched = Simulation(settings(query).run)
    person = watched.source()
    while watched.time < 1.0:
        watched.step(person.target(watched.time))
        sample = watched.sample()
        now = contact(watched, sample)
        shown = (
            budget_terms(watched, sample, now),
            section_html(watched, sample, now),
            error_html(watched, sample),
        )
        assert all(shown)
    assert watched.history.table().tobytes() == played(query).history.table().tobytes()


ANGLES = st.lists(st.floats(-1.2, 1.2), min_size=7, max_size=7)


@given(ANGLES, st.floats(-1.0, 1.0))
def test_the_elbow_angle_ignores_the_base_and_changes_sign_in_a_mirror(
    angles: list[float], turn: float
) -> None:
    room = build_alone()
    q = np.array(angles)
    q[3] = 0.4 + abs(q[3])
    angle = Swivel(room, room.arms[0]).angle(q)
    if math.isnan(angle):
        return
    assert abs(angle) <= math.pi
    assert room.rig.bases[0].rotation[2, 2] == pytest.approx(1.0, abs=1e-12), "the base is not upright"
    turned = q + turn * np.eye(7)[0]
    assert math.remainder(Swivel(room, room.arms[0]).angle(turned) - angle, 2.0 * math.pi) == pytest.approx(
        0.0, abs=1e-6
    )
    assert math.remainder(
        Swivel(room, room.arms[0]).angle(MIRROR * q) + angle, 2.0 * math.pi
    ) == pytest.approx(0.0, abs=1e-6)


def test_the_elbow_angle_is_continuous_and_nan_for_a_straight_arm() -> None:
    room = build_alone()
    swivel = Swivel(room, room.arms[0])
    # Two turns about the upper arm.
    turns = np.linspace(0.0, 4.0 * math.pi, 400)
    angles = [swivel.angle(np.array([0.0, 0.9, turn, 1.2, 0.0, 0.0, 0.0])) for turn in turns]
    assert np.abs(np.diff(angles)).max() < 0.6
    assert math.isnan(Swivel(room, room.arms[0]).angle(np.zeros(7)))


def shown(simulation: Simulation) -> str:
    """The page's text about the newest step."""
    return parts(promise_html(simulation, simulation.sample()))


def run_until(query: str, condition: Condition) -> Simulation:
    """The experiment at the first step at which only this condition is missing."""
    return moved(settings(query).run, lambda run: missing_now(run.settings, run.history) == (condition,))


def test_the_promise_is_shown_in_the_usual_run() -> None:
    near = played("scene=ball")
    assert "s = 1.00" in shown(near)
    assert 'class="go"' in promise_html(near, near.sample())
    for scene in ("hold", "master_slave", "imitation"):
        # Far away, the closest bodies hardly move along the line: a short lever does not matter.
        assert shown(played(f"scene={scene}")).endswith("is promised")
        assert shown(Simulation(settings(f"scene={scene}").run)).endswith("is promised"), (
            "no promise before the first step"
        )
    assert shown(played("scene=master_slave")).count("; ") == 1, "not one lever per arm"
    assert shown(played("scene=solo")) == ""
    simulation = played("scene=hold")
    assert "does not promise" in text(promise_html(simulation, simulation.sample(), custom=True)), (
        "a promise for a custom law"
    )


def test_a_missing_condition_is_named() -> None:
    fast = run_until("scene=hold&wmax=0.8&v=0.05", Condition.SPEED)
    assert shown(fast).endswith("dm may fail: w > v")
    both = moved(settings("scene=imitation&v=0.05").run, lambda run: run.sample().approach > 0.1)
    assert shown(both).endswith("is promised"), "no promise although both arms avoid"
    tied = run_until(TIED, Condition.PAIRS)
    assert missing_now(tied.settings, tied.history) == (Condition.PAIRS,) and "is promised" not in shown(tied)


def test_a_failed_distance_is_reported_as_failed() -> None:
    simulation = moved(
        settings("scene=hold&wmax=0.8&v=0.05").run,
        lambda s: s.sample().distance < 0.145 and missing_now(s.settings, s.history) == (Condition.SPEED,),
    )
    assert simulation.settings.law.critical_distance == 0.15
    assert shown(simulation).endswith("dm has failed: w > v")
    sample = simulation.sample()
    now = contact(simulation, sample)
    kind, note = contact_note(simulation, sample, now, budget_terms(simulation, sample, now))
    assert kind == "alarm" and text(note) == "d ≥ dm has failed: w > v"


def test_a_joint_at_its_limit_is_named() -> None:
    simulation = run_until("scene=hold&v=1.0&wmax=1.0&dm=0.3", Condition.BOUND)
    joint = simulation.joint_label(simulation.sample().joint)
    assert shown(simulation).endswith(f"dm may fail: {joint} at its limit")


TIED = "scene=hold&start=between&avoid=guided&seed=396&v=0.05&pairs=single"


@cache
def fallen() -> Simulation:
    """A run with a distance below d_m that no longer falls."""
    return moved(
        settings(TIED).run,
        lambda run: run.sample().law_distance <= 0.1 and not missing_now(run.settings, run.history),
    )


def test_a_lost_distance_is_not_called_promised() -> None:
    assert "is promised" not in shown(fallen())


OTHER_LAWS = (
    *("law=drawn_curve&curve=0.1:1,0.2:0", "law=drawn_curve&curve=0.1:0.9,0.2:0", "law=lever&lever=0.4"),
    *(f"law={law}" for law in [*LAWS][1:] if LAW_TEXTS[law].promise is None),
)


def test_texts_of_the_promise(approve: Approve) -> None:
    said = {
        "usual run": shown(played("scene=ball")),
        "between two pairs": shown(run_until(TIED, Condition.PAIRS)),
        "bolted down": shown(bolted()),
        "lost": shown(fallen()),
        **{query: shown(played(f"scene=hold&{query}", 0.1)) for query in OTHER_LAWS},
    }
    # The lever depends on the run.
    approve("promise.txt", re.sub(r"s = [\d.]+(; [\d.]+)?", "s = #", case_lines(said)))


def test_the_tip_explains_the_cost_of_five_joints(approve: Approve) -> None:
    session = Session(settings("scene=hold"))
    whole = tip_text(session)
    short = tuple(
        replace(arm, joints=slice(arm.joints.start, arm.joints.start + 5))
        for arm in session.simulation.room.arms
    )
    session.simulation.room = replace(session.simulation.room, arms=short)
    assert tip_text(session) != whole
    approve("tip.txt", case_lines({"seven joints": whole, "five joints": tip_text(session)}))
