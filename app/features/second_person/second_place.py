"""A second person's place in a session."""

from typing import ClassVar

import msgspec

from app.session.parts import SessionPart
from app.session.session import Session


class SecondPlace(SessionPart):
    """Place of a second person in a session.

    `word`: of the link; "" without an invitation. `guest`: their page, or None.
    """

    name: ClassVar[str] = "invitation"
    """As the field of earlier releases."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self.word = ""
        self.guest: object = None

    def saved(self) -> bytes:
        return msgspec.msgpack.encode(self.word) if self.word else b""

    def restore(self, saved: bytes) -> None:
        """A damaged record opens no link."""
        try:
            self.word = msgspec.msgpack.decode(saved, type=str)
        except msgspec.MsgspecError:
            self.word = ""
