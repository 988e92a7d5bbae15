"""Some seconds of random actions. Longer: `python -m tests.tools.monkey --seeds 1 2 3 4 5 --seconds 60`."""

import logging

import numpy as np
import pytest
from playwright.sync_api import Browser

from app.session.session import Session
from app.settings import Settings
from tests.tools.monkey.visitor import Trouble, assert_sound, let_loose, watching


@pytest.mark.thorough
def test_five_seconds_of_random_actions(browser: Browser) -> None:
    monkey = let_loose(browser, seed=1, seconds=5.0, least=5)
    # The effects of an action are listed below it, indented.
    actions = [line for line in monkey.done if not line.startswith(" ")]
    assert len(actions) >= 5 and sum(monkey.counts.values()) == len(actions)


def test_forbidden_states_and_logged_errors_are_detected() -> None:
    session = Session(Settings())
    assert_sound(session)
    for position, message in ((np.nan, "not finite"), (9.0, r"out of its bounds by [67]\.")):
        session.simulation.positions[3] = position
        with pytest.raises(Trouble, match=message):
            assert_sound(session)
    log = logging.getLogger("duet.session")
    with watching() as watch:
        log.warning("this is no error")
        watch.check()
        log.error("this is one")
        with pytest.raises(Trouble, match="this is one"):
            watch.check()
    log.error("this comes too late")
    assert len(watch.complaints) == 1
