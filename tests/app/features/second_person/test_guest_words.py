"""Texts for a guest."""

from app.features.second_person.guest import guest_tip
from app.session.frame import freeze
from app.session.session import Session
from app.settings import Settings


def test_a_guest_reads_that_the_hand_returns_and_what_to_pull() -> None:
    words = guest_tip(freeze(Session(Settings()), 0.0).shown)
    assert "goes back to its ring" in words and "pull the elbow" in words
