"""A visitor of a shared server writes a formula on the page, in Compare and in lesson 10."""

import pytest

from app.features.custom_law.trials import TRIALS
from app.features.formula_law.formula import BadFormula, Formula
from app.features.formula_law.formula_editor import StopFormula
from app.features.formula_law.formula_law import FILE
from app.features.formula_law.session_formula import FIRST, PAPER, SessionFormula
from scenes.laws import DEFAULT_LAW
from tests.app.conftest import Arrive, OpenHouse
from tests.app.features.custom_law.test_edited_law import enter, state_of
from tests.app.features.lessons.helpers import lessons_of
from tests.app.features.lessons.test_trials import to_challenge
from tests.app.inline import Inline
from tests.app.page.helpers import buttons, shown

pytestmark = pytest.mark.slow

BACK = "Back to the law of the settings"


def test_a_visitor_runs_a_formula_beside_the_papers_law_and_goes_back(
    house: OpenHouse, arrive: Arrive
) -> None:
    guest = arrive(house(host="0.0.0.0"), "ghost=off&law=unprotected")
    guest.visitor.wait_for(state_of)
    first = state_of(guest.visitor) or {}
    assert first["text"] == FIRST and first["sha"] == "" and "Your law: a formula" in shown(guest.visitor)
    enter(guest.visitor, first["box"], "d.__class__", 1)
    guest.visitor.wait_for(lambda v: (state_of(v) or {})["number"] == "1")
    state = state_of(guest.visitor) or {}
    with pytest.raises(BadFormula) as refusal:
        Formula("d.__class__")
    assert state["said"] == "refused" and state["refused"] == str(refusal.value)
    assert not guest.session.law.given
    enter(guest.visitor, first["box"], PAPER, 2)
    guest.visitor.wait_for(lambda v: (state_of(v) or {})["said"] == "saved")
    assert guest.session.settings.page.ghost == DEFAULT_LAW and guest.session.law_status.file == FILE
    guest.visitor.wait_for(lambda v: BACK in buttons(v))
    guest.ask(lambda session: session.post(StopFormula()))
    guest.visitor.wait_for(lambda v: BACK not in buttons(v))
    assert not guest.session.law.given and guest.session.parts.of(SessionFormula).text == PAPER
    # Too long for a formula, but short enough for an entry.
    enter(guest.visitor, first["box"], "(" * 20_000, 3)
    guest.visitor.wait_for(lambda v: (state_of(v) or {})["number"] == "3")
    assert "20000 characters" in (state_of(guest.visitor) or {})["refused"]


def test_the_step_of_lesson_ten_is_passed_with_a_formula(house: OpenHouse, arrive: Arrive) -> None:
    desk = Inline()
    guest = arrive(house(jobs=desk), "lesson=10&step=5")
    guest.ask(lambda session: to_challenge(session, lessons_of(guest)))
    guest.visitor.wait_for(state_of)
    box = (state_of(guest.visitor) or {})["box"]
    enter(guest.visitor, box, PAPER, 1)
    guest.visitor.wait_for(lambda v: (state_of(v) or {})["said"] == "saved")
    assert [kind for name in TRIALS for kind in desk.work(name)] == list(TRIALS)
    guest.visitor.wait_for(
        lambda v: [kind for kind, _ in (state_of(v) or {})["lamps"]] == ["ok"] * len(TRIALS)
    )
    guest.visitor.wait_for(lambda v: "Challenge passed." in shown(v))
    assert guest.ask(lambda _: lessons_of(guest).walk.done.passed)
    assert guest.session.settings.page.ghost == DEFAULT_LAW and guest.session.law.of_run is not None
