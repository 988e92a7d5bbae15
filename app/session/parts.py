"""What features keep with a session: one object of each class, what it does as the session goes on, and its bytes in the record."""

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, TypeVar

from app.settings import Settings


class SessionPart:
    """State of a feature, made at the first request; a subclass overrides what it needs.

    All methods belong to the thread that advances the session.

    Args:
        session: the `app.session.session.Session` that it belongs to. Sessions import this file, so that it cannot import their class.

    Attributes:
        name: of its bytes in the record; unique among all parts.
    """

    name: ClassVar[str] = ""

    def __init__(self, session: Any) -> None:
        pass

    def saved(self) -> bytes:
        """Bytes for the record; empty if there is nothing to restore."""
        return b""

    def restore(self, saved: bytes) -> None:
        """Restore what `saved` returned, in this process or in an earlier one; raises nothing."""

    def advance(self, elapsed: float) -> None:
        """Take in what was computed, before the actions of a frame. `elapsed`: wall time since the last frame [s]."""

    def decide(self) -> None:
        """Begin, stop or measure the run, after the actions of a frame and before its steps."""

    def changed(self, before: Settings, after: Settings, rebuilt: bool) -> None:
        """Follow a change of the settings. `rebuilt`: whether the run is of another experiment now."""

    def reset(self) -> None:
        """Drop what is about the run before a reset."""

    def close(self) -> None:
        """Drop everything that is being computed."""


P = TypeVar("P", bound=SessionPart)


class SessionParts:
    """The parts of one session, by their class.

    Args:
        session: of the parts.
    """

    def __init__(self, session: Any) -> None:
        self._session = session
        self._made: dict[type[SessionPart], SessionPart] = {}
        self._waiting: dict[str, bytes] = {}

    def __iter__(self) -> Iterator[SessionPart]:
        """The parts that were made, in the order of the first requests; a part may ask for others meanwhile."""
        return iter(tuple(self._made.values()))

    def of(self, kind: type[P]) -> P:
        """The session's part of a class."""
        part = self._made.get(kind)
        if part is None:
            part = self._made[kind] = kind(self._session)
            if kind.name in self._waiting:
                part.restore(self._waiting.pop(kind.name))
        assert isinstance(part, kind)
        return part

    def saved(self) -> dict[str, bytes]:
        """Name → bytes of every part that has something to restore, also of those that were not asked for."""
        made = {part.name: part.saved() for part in self}
        return {name: saved for name, saved in (self._waiting | made).items() if saved}

    def restore(self, saved: Mapping[str, bytes]) -> None:
        """Restore the parts of a record; each as soon as it is asked for."""
        self._waiting |= saved
        for part in self:
            if part.name in self._waiting:
                part.restore(self._waiting.pop(part.name))
