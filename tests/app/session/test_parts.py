"""What features keep with a session: one object of each class, whose bytes outlive the session."""

from typing import ClassVar

from app.session.parts import SessionParts
from app.session.session import Session
from app.settings import Settings


class Count:
    name: ClassVar[str] = "count"

    def __init__(self) -> None:
        self.value = 0

    def saved(self) -> bytes:
        return str(self.value).encode() if self.value else b""

    def restore(self, saved: bytes) -> None:
        self.value = int(saved)


class Word:
    name: ClassVar[str] = "word"

    def __init__(self) -> None:
        self.text = ""

    def saved(self) -> bytes:
        return self.text.encode()

    def restore(self, saved: bytes) -> None:
        self.text = saved.decode()


def test_a_session_has_one_part_of_each_class() -> None:
    one, other = Session(Settings()), Session(Settings())
    assert one.parts.of(Count) is one.parts.of(Count) is not other.parts.of(Count)
    assert isinstance(one.parts.of(Word), Word)


def test_parts_are_saved_and_restored_whether_they_are_asked_for_or_not() -> None:
    parts = SessionParts()
    assert parts.saved() == {}
    parts.of(Count).value, parts.of(Word).text = 3, "open"
    saved = parts.saved()
    assert saved == {"count": b"3", "word": b"open"}
    late = SessionParts()
    late.restore(saved)
    assert late.saved() == saved, "a part of a feature that is missing here is not lost"
    assert late.of(Count).value == 3 and late.saved() == saved
    early = SessionParts()
    word = early.of(Word)
    early.restore(saved)
    assert word.text == "open" and early.of(Count).value == 3
    # What has ended since is not restored again.
    word.text = ""
    assert early.saved() == {"count": b"3"}
