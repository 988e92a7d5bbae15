"""Numbers and words: what they say is what the simulation does, in every experiment and under every law."""

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
from tests.scenes.helpers import moved

SCENES = tuple(EXPERIMENTS)
RUNNING = Pace(False, 1.0, False)


def settings(query: str) -> Settings:
    made, problems = from_query(dict(part.split("=") for part in query.split("&")), Settings())
    assert not problems
    return made


@cache
def played(query: str, seconds: float = 1.0) -> Simulation:
    """An experiment that its own person has moved for a while; not to be moved on."""
    return moved(settings(query).run, lambda simulation: simulation.time >= seconds)


def seen(query: str, seconds: float = 1.0) -> tuple[Simulation, Sample, Contact]:
    """What is shown of such an experiment: itself, its newest sample and its contact."""
    simulation = played(query, seconds)
    sample = simulation.sample()
    return simulation, sample, contact(simulation, sample)


def text(html: str) -> str:
    return unescape(re.sub(r"<[^>]+>", "", str(html))).replace("\u00a0", " ")


def shares(terms: list[Term]) -> str:
    """What opens the gap and what closes it, as a formula."""
    return " ".join(
        f"{'−' if term.kind in ('u', 'w') else '+'}{text(term.symbol)}"
        for term in terms
        if term.kind != "lost"
    )


VARIANTS = ("", "&avoid=both", "&avoid=both&coupled=1", "&avoid=guided", "&ff=1", "&pairs=single")


LEAVES_SOME = ("null_space_avoidance", "barrier_qp", "task_activation", "continuous_inverse")
"""Laws whose distance rate is not that of their line wherever the hand or another pair counts, too."""


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("scene", ["ball", "hold", "master_slave", "imitation"])
def test_the_budget_is_what_happens(scene: str, law: str) -> None:
    """ḋ by the law's own line is ḋ by J_d and q̇, and the numbers on the page come to the same."""
    for variant in VARIANTS:
        # No other test shows these.
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


def test_a_law_that_gets_less_than_it_asks_for_says_so() -> None:
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
def test_symbol_and_number_of_a_switch_belong_together(activation: float) -> None:
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


@pytest.mark.parametrize(
    ("query", "words"),
    [
        ("k=0", "nothing brings e back"),
        ("k=2", "shrinks by 1.0 % a step"),
        ("k=20&kx=10&dt=0.005", "changes its sign"),
        ("k=20&kx=10&dt=0.02", "grows until the joints are at their top speed"),
    ],
)
def test_the_arm_alone_says_what_k_dt_does(query: str, words: str) -> None:
    simulation, sample, _ = seen(f"scene=solo&path=circle&{query}", 0.1)
    assert words in text(error_step(simulation.settings))
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
def test_the_trace_of_n_counts_what_the_hand_leaves_free(robot: str, task: str, free: float) -> None:
    simulation = played(f"scene=solo&robot={robot}&task={task}", 0.3)
    assert float(tile_values(tiles_html(simulation, simulation.sample()))[1]) == free


def test_the_ghost_has_an_error_beside_the_runs() -> None:
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
    moved_by_joints = next(
        p for p, names in enumerate(simulation.detector.pair_names) if "pedestal" not in " ".join(names)
    )
    for s, said in ((0.05, "no joint moves this point"), (0.6, "the joints hardly move this point")):
        short = replace(sample, authority=int(Authority.LEVERAGE), joint=-1, lever=s, pair=moved_by_joints)
        assert said in status_html(RUNNING, simulation, short)


def test_a_large_d_m_that_meets_a_pedestal_is_told_without_jargon() -> None:
    """With d_m at 300 mm the nearest body of the silver arm is its pedestal, which no joint moves."""
    simulation = moved(
        settings("scene=hold&dm=0.3").run, lambda s: s.sample().authority == Authority.LEVERAGE
    )
    sample = simulation.sample()
    assert "pedestal" in simulation.detector.pair_names[sample.pair][0]
    words = text(status_html(RUNNING, simulation, sample))
    assert (
        "Bolted down: a smaller d_m helps." in words and "no joint" not in words and "authority" not in words
    )
    # The card has no good news then, and the promise the same reason.
    now = contact(simulation, sample)
    kind, note = contact_note(simulation, sample, now, budget_terms(simulation, sample, now))
    assert kind != "go" and note.endswith("the nearest part is bolted down")
    assert "no joint" not in promise_html(simulation, sample)
    # Of a body that a joint moves it is not said.
    moving = next(p for p, (own, _) in enumerate(simulation.detector.pair_names) if own == "left forearm")
    assert "Bolted" not in status_html(RUNNING, simulation, replace(sample, pair=moving))


def test_a_short_lever_is_no_warning_where_lambda_does_not_act() -> None:
    simulation, sample, _ = seen("scene=hold")
    far = replace(
        sample, lever=0.4, activation=0.0, distance=0.37, law_distance=0.37, authority=int(Authority.FULL)
    )
    assert 'class="halt"' not in promise_html(simulation, far)
    assert 'class="halt"' in promise_html(simulation, replace(far, activation=0.2))


def test_who_is_faster_than_v() -> None:
    for query, words in (
        ("scene=hold", "the hand is faster than v"),
        ("scene=ball", "the ball is faster than v"),
    ):
        simulation, sample, _ = seen(query)
        fast = replace(sample, law_approach=0.31)
        assert words in status_html(RUNNING, simulation, fast)
        for other in (f"{query}&ff=1", f"{query}&law=barrier_qp", f"{query}&law=unprotected"):
            assert "faster" not in status_html(RUNNING, played(other), fast)
    # Where both keep clear the bound holds for any v > 0.
    simulation, sample, _ = seen("scene=master_slave")
    assert "faster" not in status_html(RUNNING, simulation, replace(sample, law_approach=0.31))


def test_slowed_is_not_said_while_the_run_is_paused() -> None:
    clock = Clock(1.0)
    for _ in range(10):
        clock.note(0, 1, 0.5, 0.002)
    assert clock.pace(False).slowed and not clock.pace(True).slowed


VARIED = "&path=circle &ball=cross &point=arm &following=identical &avoid=both &avoid=guided &avoid=free &autopilot=0"


@pytest.mark.parametrize("scene", SCENES)
def test_a_tip_for_everything_that_can_be_chosen(scene: str) -> None:
    tips = {tip_text(Session(settings(f"scene={scene}{variant}"))) for variant in ("", *VARIED.split())}
    assert all(25 < len(text(tip)) < 170 and tip.endswith(".") for tip in tips) and len(tips) > 1
    # Who watches a stage can pull nothing.
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
def test_an_equation_and_a_source_of_every_law(law: str) -> None:
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


def test_section_three_speaks_of_its_custom_law_only() -> None:
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
    # The row would be of one arm and the Jacobian of the other one, which may have fewer joints.
    assert "keeps clear" in text(section_html(*seen("scene=hold&robot=lwr_ur5&avoid=guided")))
    simulation = moved(settings("scene=hold").run, lambda s: s.time >= 1.0)
    sample = simulation.sample()
    now = contact(simulation, sample)
    simulation.use(ReplayedLaw([LawAnswers("mine.py", "0" * 64, np.zeros((1, 8)))], simulation, 0))
    assert "Of this law it says nothing" in text(section_html(simulation, sample, now))


@pytest.mark.parametrize(
    "query", ["scene=hold", "scene=hold&task=pose", "scene=master_slave", "scene=ball&point=elbow"]
)
def test_section_three_is_about_this_moment(query: str) -> None:
    simulation, sample, now = seen(query, 4.0)
    error, J = task_error(simulation, sample)
    position = error if J is None else error[:3]
    assert float(position.dot(position)) == pytest.approx(sample.squared_error, rel=1e-9, abs=1e-12)
    # As the law saw it: u = −J_d q̇_n.
    run = simulation.settings
    analysis = analyse(now.row, J, sample.activation, run.gain, run.gain, damped=True)
    least = f"{analysis.smallest_eigenvalue:+.2f}".replace("-", "−")
    assert least in text(section_html(simulation, sample, now)) or abs(analysis.smallest_eigenvalue) < 0.005


def test_the_numbers_leave_the_run_alone() -> None:
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
def test_the_elbow_angle_knows_no_turn_of_the_base_and_changes_sign_in_a_mirror(
    angles: list[float], turn: float
) -> None:
    room = build_alone()
    q = np.array(angles)
    q[3] = 0.4 + abs(q[3])
    angle = Swivel(room, room.arms[0]).angle(q)
    if math.isnan(angle):
        return
    assert abs(angle) <= math.pi
    assert room.rig.bases[0].rotation[2, 2] == pytest.approx(1.0, abs=1e-12), "the base stands upright"
    turned = q + turn * np.eye(7)[0]
    assert math.remainder(Swivel(room, room.arms[0]).angle(turned) - angle, 2.0 * math.pi) == pytest.approx(
        0.0, abs=1e-6
    )
    assert math.remainder(
        Swivel(room, room.arms[0]).angle(MIRROR * q) + angle, 2.0 * math.pi
    ) == pytest.approx(0.0, abs=1e-6)


def test_the_elbow_angle_does_not_jump_by_a_turn_and_is_none_of_a_straight_arm() -> None:
    room = build_alone()
    swivel = Swivel(room, room.arms[0])
    # Twice round about the upper arm.
    turns = np.linspace(0.0, 4.0 * math.pi, 400)
    angles = [swivel.angle(np.array([0.0, 0.9, turn, 1.2, 0.0, 0.0, 0.0])) for turn in turns]
    assert np.abs(np.diff(angles)).max() < 0.6
    assert math.isnan(Swivel(room, room.arms[0]).angle(np.zeros(7)))


def shown(simulation: Simulation) -> str:
    """What the page says of the newest step."""
    return text(promise_html(simulation, simulation.sample()))


def run_until(query: str, condition: Condition) -> Simulation:
    """The experiment at the first step that misses nothing but a condition."""
    return moved(settings(query).run, lambda run: missing_now(run.settings, run.history) == (condition,))


def test_it_stands_in_the_usual_run() -> None:
    near = played("scene=ball")
    assert shown(near) == "joints move this point: s = 1.00d ≥ dm is promised"
    assert 'class="go"' in promise_html(near, near.sample())
    for scene in ("hold", "master_slave", "imitation"):
        # Far away, where the closest bodies hardly move along the line: the lever is short, and costs nothing.
        assert shown(played(f"scene={scene}")).endswith("is promised")
        assert shown(Simulation(settings(f"scene={scene}").run)).endswith("is promised"), (
            "before the first step"
        )
    assert shown(played("scene=master_slave")).count("; ") == 1, "one lever an arm"
    assert shown(played("scene=solo")) == ""
    simulation = played("scene=hold")
    assert "does not promise" in text(promise_html(simulation, simulation.sample(), custom=True)), (
        "a law of your own"
    )


def test_a_missing_condition_is_named() -> None:
    fast = run_until("scene=hold&wmax=0.8&v=0.05", Condition.SPEED)
    assert shown(fast).endswith("dm may fail: w > v")
    both = moved(settings("scene=imitation&v=0.05").run, lambda run: run.sample().approach > 0.1)
    assert shown(both).endswith("is promised"), "the other one keeps clear, too"
    tied = run_until("scene=hold&start=between&avoid=guided&seed=396&v=0.05&pairs=single", Condition.PAIRS)
    assert shown(tied).endswith("dm may fail: between two pairs")


def test_what_has_failed_is_not_said_to_be_possible() -> None:
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


@pytest.mark.parametrize(
    ("query", "said"),
    [
        ("law=drawn_curve&curve=0.1:1,0.2:0", "this curve promises d ≥ 100 mm while w ≤ v"),
        ("law=drawn_curve&curve=0.1:0.9,0.2:0", "this curve promises nothing: it does not begin at 1"),
        ("law=lever&lever=0.4", "your lever promises nothing: it does not depend on d"),
        *(
            (f"law={law}", "this law does not promise d ≥ dm")
            for law in [*LAWS][1:]
            if LAW_TEXTS[law].promise is None
        ),
    ],
)
def test_what_another_law_promises(query: str, said: str) -> None:
    assert shown(played(f"scene=hold&{query}", 0.1)).endswith(said)


def test_a_distance_that_was_lost_is_not_said_to_be_kept() -> None:
    lost = settings("scene=hold&start=between&avoid=guided&seed=396&v=0.05&pairs=single").run
    run = moved(
        lost, lambda run: run.sample().law_distance <= 0.1 and not missing_now(run.settings, run.history)
    )
    assert shown(run).endswith("below dm, but falling no further")


def test_what_five_joints_cost_is_said_where_a_hand_keeps_its_place() -> None:
    session = Session(settings("scene=hold"))
    assert "Five joints" not in tip_text(session)
    short = tuple(
        replace(arm, joints=slice(arm.joints.start, arm.joints.start + 5))
        for arm in session.simulation.room.arms
    )
    session.simulation.room = replace(session.simulation.room, arms=short)
    assert tip_text(session).endswith(
        "Five joints keep the hand’s place, not its turn: two are left for everything else, not four."
    )
