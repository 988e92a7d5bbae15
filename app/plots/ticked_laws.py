"""A visitor's ticked laws, drawn beside the running one."""

from typing import ClassVar, Final

from app.session.parts import SessionPart
from scenes.laws import LAWS

MOST: Final = 3


class TickedLaws(SessionPart):
    """Ticked laws; a further one replaces the oldest.

    Attributes:
        places: name → its place, from 0, while ticked; the oldest law first.
    """

    name: ClassVar[str] = "ticked_laws"
    places: dict[str, int]

    def __init__(self, session: object) -> None:
        self.places = {}

    def tick(self, law: str) -> None:
        # A frame that is being drawn keeps the laws that it has read.
        places = dict(self.places)
        if places.pop(law, None) is None and law in LAWS:
            if len(places) == MOST:
                places.pop(next(iter(places)))
            places[law] = min(set(range(MOST)) - set(places.values()))
        self.places = places

    def saved(self) -> bytes:
        return ",".join(self.places).encode()

    def restore(self, saved: bytes) -> None:
        for law in saved.decode("utf-8", "replace").split(","):
            if law not in self.places:
                self.tick(law)
