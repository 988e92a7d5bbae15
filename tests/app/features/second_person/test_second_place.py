"""The word of an invitation outlives the server, also if an earlier release stored it."""

import msgspec

from app.features.second_person.second_place import SecondPlace
from app.session.parts import SessionParts
from app.session.session import Session
from app.settings import Settings


def test_the_word_is_restored_and_a_damaged_part_opens_no_link() -> None:
    parts = SessionParts(Session(Settings()))
    parts.of(SecondPlace).word = "5f3a"
    # The same as the earlier field `invitation` of a record.
    assert parts.saved() == {"invitation": msgspec.msgpack.encode("5f3a")}
    for saved, word in ((parts.saved(), "5f3a"), ({"invitation": b"\xc1"}, ""), ({}, "")):
        again = SessionParts(Session(Settings()))
        again.restore(saved)
        assert again.of(SecondPlace).word == word
