"""The place of a second person in a session: word of its link, and guest."""

from typing import ClassVar

import msgspec

from app.session.parts import SessionPart
from app.session.session import Session


class SecondPlace(SessionPart):
    """A part of a session, see `app.session.parts`.

    Attributes:
        word: of the link; "" without an invitation.
        guest: their page, or None.
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
        """Open the saved link; a damaged record opens none."""
        try:
            self.word = msgspec.msgpack.decode(saved, type=str)
        except msgspec.MsgspecError:
            self.word = ""
