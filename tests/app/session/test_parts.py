"""Parts of features in a session: one object of each class; its saved bytes outlive the session."""

from typing import ClassVar

from app.session.frame import make_frame
from app.session.parts import SessionPart, SessionParts
from app.session.session import Session
from app.settings import Settings


class Count(SessionPart):
    name: ClassVar[str] = "count"

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self.value = 0

    def saved(self) -> bytes:
        return str(self.value).encode() if self.value else b""

    def restore(self, saved: bytes) -> None:
        self.value = int(saved)


class Word(SessionPart):
    name: ClassVar[str] = "word"

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self.text = ""

    def saved(self) -> bytes:
        return self.text.encode()

    def restore(self, saved: bytes) -> None:
        self.text = saved.decode()


def test_a_session_has_one_part_of_each_class() -> None:
    one, other = Session(Settings()), Session(Settings())
    assert one.parts.of(Count) is one.parts.of(Count) is not other.parts.of(Count)
    assert isinstance(one.parts.of(Word), Word)


def test_parts_are_saved_and_restored_with_or_without_use() -> None:
    session = Session(Settings())
    parts = SessionParts(session)
    assert parts.saved() == {}
    parts.of(Count).value, parts.of(Word).text = 3, "open"
    saved = parts.saved()
    assert saved == {"count": b"3", "word": b"open"}
    late = SessionParts(session)
    late.restore(saved)
    assert late.saved() == saved, "the part of a missing feature is lost"
    assert late.of(Count).value == 3 and late.saved() == saved
    early = SessionParts(session)
    word = early.of(Word)
    early.restore(saved)
    assert word.text == "open" and early.of(Count).value == 3
    # An emptied part is not restored again.
    word.text = ""
    assert early.saved() == {"count": b"3"}


class Follower(SessionPart):
    name: ClassVar[str] = "follower"

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self.session, self.told = session, list[object]()

    def advance(self, elapsed: float) -> None:
        self.told.append(("advance", elapsed))

    def decide(self) -> None:
        self.told.append("decide")

    def changed(self, before: Settings, after: Settings, rebuilt: bool) -> None:
        self.told.append((before.run.scene, after.run.scene, rebuilt))

    def reset(self) -> None:
        self.told.append("reset")

    def close(self) -> None:
        self.told.append("close")


def test_a_part_follows_its_session() -> None:
    session = Session(Settings())
    follower = session.parts.of(Follower)
    assert follower.session is session
    make_frame(session, 0.0, 0.25)
    assert follower.told == [("advance", 0.25), "decide"]
    follower.told.clear()
    session.change("scene", "imitation")
    session.change("dm", 0.2)
    session.reset()
    session.close()
    assert follower.told == [("hold", "imitation", True), ("imitation", "imitation", False), "reset", "close"]
