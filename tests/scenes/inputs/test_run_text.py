"""A short run as text for a link: restored to the bit; damaged or long texts are refused by name."""

import base64
import zlib
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.web.pages import LONGEST_PUSH, page_query
from controllers.errors import BadInputFile, BadSetting
from scenes.inputs import InputsLog, Recorded
from scenes.rerun import rerun
from scenes.run_text import GRID, LONGEST, LONGEST_TEXT, on_grid, run_of_text, run_text
from scenes.simulation import Simulation
from scenes.targets import HandTarget, LinkTarget, Target
from tests.approved import Approve, case_lines
from tests.scenes.helpers import given_settings, refusal

Push = Callable[[Simulation, int], Target | None]


def by_the_hand(simulation: Simulation, step: int) -> Target | None:
    """No target, a pull at the hand as a browser sends it, a pull at a link, no target."""
    if step < 40 or step >= 160:
        return None
    way = np.array([-0.01, 0.0013, 0.0007]) * (step // 10 - 3)
    if step < 120:
        pose = Simulation(simulation.settings, 1).kinematics.hand_pose(simulation.guided)
        return HandTarget(pose.translation + way, pose.rotation)
    return LinkTarget(5, np.array([0.011, 0.02, -0.003]), np.array([0.3, 0.1, 1.2]) + way)


def recorded(push: Push = by_the_hand, steps: int = 200, dt: float = 0.005) -> Recorded:
    settings = given_settings(rig="table", pairs="smooth", wmax=0.25, v=0.3, dt=dt)
    simulation, log = Simulation(settings, steps), InputsLog()
    for step in range(steps):
        target = on_grid(push(simulation, step))
        log.record(simulation, target)
        simulation.step(target)
    run = log.window(1000.0)
    assert run is not None
    return run


RUN = recorded()
TEXT = run_text(RUN)


def test_a_link_gives_the_same_bits() -> None:
    again = run_of_text(TEXT)
    assert rerun(again).table.tobytes() == rerun(RUN).table.tobytes()
    assert again.settings == RUN.settings and run_text(again) == TEXT
    assert len(TEXT) < 600 and TEXT.replace("-", "").replace("_", "").isalnum(), "the text needs quoting"
    assert page_query(f"/?push={TEXT}")["push"] == TEXT


def test_a_grid_position_is_within_half_a_cell_and_does_not_move_again() -> None:
    place = np.array([0.1, -0.2, 1.2345])
    held = on_grid(HandTarget(place, None))
    assert isinstance(held, HandTarget) and np.abs(held.position - place).max() <= GRID / 2.0
    again = on_grid(held)
    assert isinstance(again, HandTarget) and (again.position == held.position).all() and on_grid(None) is None


# The last letter has unused bits.
@given(st.integers(0, len(TEXT) - 2), st.sampled_from("Aq7-_ é"))
def test_a_damaged_link_is_refused_by_name(place: int, letter: str) -> None:
    damaged = TEXT[:place] + letter + TEXT[place + 1 :]
    if damaged != TEXT:
        with pytest.raises(BadInputFile, match=r"^push: .*damaged"):
            run_of_text(damaged)
    with pytest.raises(BadInputFile, match="damaged"):
        run_of_text(TEXT[:place])


def forged(body: bytes) -> str:
    """A text with a correct checksum."""
    body = zlib.compress(body)
    return base64.urlsafe_b64encode(zlib.crc32(body).to_bytes(4, "big") + body).decode().rstrip("=")


def test_a_forged_link_is_refused_like_a_forged_file() -> None:
    plain = zlib.decompress(base64.urlsafe_b64decode(TEXT + "=" * (-len(TEXT) % 4))[4:])
    for body, why in (
        (b"\2" + plain[1:], "another version"),
        (plain.replace(b'"wmax": 0.25', b'"wmax": 1e99'), "wmax"),
        (plain.replace(b'"rig"', b'"gir"'), "gir"),
        (plain[:-1], "damaged"),
        (plain + b"\0", "damaged"),
        (plain + bytes(300_000), "damaged"),
        (plain.replace(b"\x13\x13", b"\xff\xff"), "damaged"),
    ):
        if body != plain:
            with pytest.raises(BadInputFile, match=f"^push: .*{why}"):
                run_of_text(forged(body))
    with pytest.raises(BadInputFile, match=f"longer than {LONGEST_TEXT}"):
        run_of_text("A" * (LONGEST_TEXT + 1))
    # A page also reports a text that is too long.
    assert LONGEST_PUSH == LONGEST_TEXT < len(page_query("/?push=" + "A" * 3900)["push"])


def test_a_run_that_does_not_fit_is_refused_with_the_reason() -> None:
    rng = np.random.default_rng(1)
    with pytest.raises(BadSetting, match="too long for a link"):
        run_text(
            recorded(lambda s, i: HandTarget(np.array([0.4, 0.0, 1.2]) + rng.normal(size=3), None), 1500)
        )
    with pytest.raises(BadSetting, match="too long for a link"):
        run_text(recorded(lambda s, i: None, round(LONGEST / 0.02) + 2, 0.02))
    from_the_middle = Recorded(Simulation(RUN.settings, 1).snapshot(), RUN.stretches)
    from_the_middle.snapshot.positions[0] += 0.1
    with pytest.raises(BadSetting, match="from the beginning"):
        run_text(from_the_middle)


def test_messages_of_wrong_links(approve: Approve) -> None:
    said = {
        "damaged": refusal(lambda: run_of_text(TEXT[:-1])),
        "too long": refusal(lambda: run_of_text("A" * (LONGEST_TEXT + 1))),
    }
    approve("wrong links.txt", case_lines(said))
