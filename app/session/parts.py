"""What features keep with a session: one object of each class, what it does as the session goes on, and its bytes in the record."""

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, TypeVar

from app.settings import Settings
from scenes.inputs import Recorded
from scenes.rerun import WhatIf


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

    def recordings(self) -> Mapping[str, Recorded]:
        """Name → recorded run of those that the record keeps for this part; each is written once."""
        return {}

    def restore_recordings(self, recordings: Mapping[str, Recorded]) -> None:
        """Restore what `recordings` returned, just before `restore`. `recordings`: also those of other parts."""

    @property
    def leads(self) -> bool:
        """True while the part begins and stops the runs."""
        return False

    @property
    def hands_off(self) -> bool:
        """True while the part moves what the visitor could move."""
        return False

    @property
    def history(self) -> float | None:
        """Time before a restored run's newest step of which the part needs the curves [s]; None if the run must begin again."""
        return 0.0

    def run_restored(self) -> None:
        """Take note that the session has gone on with the run of its record."""

    def link(self, query: dict[str, str]) -> dict[str, str]:
        """Query of a link that shows the session as it is now. `query`: that of its settings."""
        return query

    def advance(self, elapsed: float) -> None:
        """Take in what was computed, before the actions of a frame. `elapsed`: wall time since the last frame [s]."""

    def decide(self) -> None:
        """Begin, stop or measure the run, after the actions of a frame and before its steps."""

    def changed(self, before: Settings, after: Settings, rebuilt: bool) -> None:
        """Follow a change of the settings. `rebuilt`: whether the run is of another experiment now."""

    def law_changed(self) -> None:
        """Take note that the session was given a law besides the settings' law, or has lost it."""

    def open_link(self, query: Mapping[str, str]) -> tuple[str, ...]:
        """Do what the visitor's link asks for besides settings, when the run has begun; the messages about what is not possible."""
        return ()

    def curves(self) -> WhatIf | None:
        """How the newest part of the run would have gone otherwise, for the plots over time; None without an answer."""
        return None

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
        self._recordings: dict[str, Recorded] = {}

    def __iter__(self) -> Iterator[SessionPart]:
        """The parts that were made, in the order of the first requests; a part may ask for others meanwhile."""
        return iter(tuple(self._made.values()))

    def of(self, kind: type[P]) -> P:
        """The session's part of a class."""
        part = self._made.get(kind)
        if part is None:
            part = self._made[kind] = kind(self._session)
            self._restore(part)
        assert isinstance(part, kind)
        return part

    def saved(self) -> dict[str, bytes]:
        """Name → bytes of every part that has something to restore, also of those that were not asked for."""
        made = {part.name: part.saved() for part in self}
        return {name: saved for name, saved in (self._waiting | made).items() if saved}

    def recordings(self) -> dict[str, Recorded]:
        """Name → recorded run of all parts, also of those that were not asked for."""
        made = {name: recorded for part in self for name, recorded in part.recordings().items()}
        return (self._recordings if self._waiting else {}) | made

    def restore(self, saved: Mapping[str, bytes], recordings: Mapping[str, Recorded] | None = None) -> None:
        """Restore the parts of a record; each as soon as it is asked for. `recordings`: what `recordings` returned."""
        self._waiting |= saved
        self._recordings |= recordings or {}
        for part in self:
            self._restore(part)

    def _restore(self, part: SessionPart) -> None:
        if part.name in self._waiting:
            part.restore_recordings(self._recordings)
            part.restore(self._waiting.pop(part.name))

    @property
    def lead(self) -> bool:
        """True while a part begins and stops the runs."""
        return any(part.leads for part in self)

    @property
    def hands_off(self) -> bool:
        """True while a part moves what the visitor could move."""
        return any(part.hands_off for part in self)
