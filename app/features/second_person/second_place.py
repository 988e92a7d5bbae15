"""The place of a second person in a session: the word of the link that leads to it, and who has it."""

from typing import ClassVar


class SecondPlace:
    """See the module; a part of a session, see `app.session.parts`.

    Attributes:
        word: of the link; "" without an invitation.
        guest: the page of the person who has the place; None while it is free.
    """

    name: ClassVar[str] = "second_person"

    def __init__(self) -> None:
        self.word = ""
        self.guest: object = None

    def saved(self) -> bytes:
        return self.word.encode()

    def restore(self, saved: bytes) -> None:
        """Open the same link again."""
        self.word = saved.decode()
