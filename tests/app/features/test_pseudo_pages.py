"""Texts of features on a page are translated, too."""

from app.features.studies.background_studies import BackgroundStudies
from tests.app.conftest import Arrive, OpenHouse, ask
from tests.app.i18n.test_pages import assert_all_said, choose


def test_texts_of_studies_and_persons_are_translated(house: OpenHouse, arrive: Arrive) -> None:
    guest = arrive(house(), "lang=pseudo&details=none&speed=2")
    choose(guest, ghost="frozen", whatif=True)
    ask(guest.session, lambda s: s.parts.of(BackgroundStudies).measure_smoothness())
    choose(guest, scene="imitation", source="camera")
    assert_all_said(guest.visitor)
