"""What features keep with a session: one object of each class, and its bytes in the visitor's record."""

from collections.abc import Mapping
from typing import ClassVar, Protocol, TypeVar


class SessionPart(Protocol):
    """State of a feature; made without arguments at the first request.

    Attributes:
        name: of its bytes in the record; unique among all parts.
    """

    name: ClassVar[str]

    def saved(self) -> bytes:
        """Bytes for the record; empty if there is nothing to restore."""
        ...

    def restore(self, saved: bytes) -> None:
        """Restore what `saved` returned, in this process or in an earlier one; raises nothing."""
        ...


P = TypeVar("P", bound=SessionPart)


class SessionParts:
    """The parts of one session, by their class."""

    def __init__(self) -> None:
        self._made: dict[type[SessionPart], SessionPart] = {}
        self._waiting: dict[str, bytes] = {}

    def of(self, kind: type[P]) -> P:
        """The session's part of a class."""
        part = self._made.get(kind)
        if part is None:
            part = self._made[kind] = kind()
            if kind.name in self._waiting:
                part.restore(self._waiting.pop(kind.name))
        assert isinstance(part, kind)
        return part

    def saved(self) -> dict[str, bytes]:
        """Name → bytes of every part that has something to restore, also of those that were not asked for."""
        made = {part.name: part.saved() for part in self._made.values()}
        return {name: saved for name, saved in (self._waiting | made).items() if saved}

    def restore(self, saved: Mapping[str, bytes]) -> None:
        """Restore the parts of a record; each as soon as it is asked for."""
        self._waiting |= saved
        for part in self._made.values():
            if part.name in self._waiting:
                part.restore(self._waiting.pop(part.name))
