"""Texts of a guest's page, without a server."""

import pytest

from app.features.second_person.guest import AWAY, CLOSED, ENDED, TAKEN, guest_tip
from app.i18n.speaking import set_language, tr
from app.session.frame import freeze
from app.session.session import Session
from app.settings import LANGUAGES, Language, Settings
from scenes.settings import RunSettings, changed
from tests.approved import Approve

HOLD = changed(RunSettings(), "avoid", "both")
RUNS = {
    "both keep clear": HOLD,
    "one keeps clear": changed(HOLD, "avoid", "free"),
    "another experiment": changed(HOLD, "scene", "ball"),
}
WAITING = {"away": AWAY, "closed": CLOSED, "ended": ENDED, "taken": TAKEN}


@pytest.mark.parametrize("language", LANGUAGES)
def test_texts_of_a_guests_page(language: Language, approve: Approve) -> None:
    set_language(language)
    said = {case: guest_tip(freeze(Session(Settings(run=run)), 0.0).shown) for case, run in RUNS.items()}
    said |= {case: tr(text) for case, text in WAITING.items()}
    approve(f"guest {language}.txt", "".join(f"{case}: {text}\n" for case, text in said.items()))
