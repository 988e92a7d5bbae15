"""State that features keep with the session."""

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, TypeVar

from app.settings import Settings
from scenes.inputs import Recorded
from scenes.rerun import WhatIf


class SessionPart:
    """State of a feature, made at the first request; a subclass overrides what it needs.

    All methods belong to the thread that advances the session (an `app.session.session.Session`). `name`: of
    its bytes in the record; unique among all parts.
    """

    name: ClassVar[str] = ""

    def __init__(self, session: Any) -> None:
        pass

    def saved(self) -> bytes:
        """Bytes for the record; empty if there is nothing to restore."""
        return b""

    def restore(self, saved: bytes) -> None:
        """Restore `saved`, perhaps of an earlier process; raises nothing."""

    def recordings(self) -> Mapping[str, Recorded]:
        """Name → recorded run for the record; each is written once."""
        return {}

    def restore_recordings(self, recordings: Mapping[str, Recorded]) -> None:
        """Restore its runs, just before `restore`. `recordings`: those of all parts."""

    @property
    def leads(self) -> bool:
        return False

    @property
    def hands_off(self) -> bool:
        return False

    @property
    def history(self) -> float | None:
        """Length of the curves needed before a restored run's newest step [s]; None if the run must
        restart."""
        return 0.0

    def run_restored(self) -> None:
        """Called when the session continues its record's run."""

    def link(self, query: dict[str, str]) -> dict[str, str]:
        """Query of a link to the session. `query`: that of its settings."""
        return query

    def advance(self, elapsed: float) -> None:
        """Collect finished computations, before a frame's actions."""

    def decide(self) -> None:
        """Start, stop or measure the run, between a frame's actions and steps."""

    def changed(self, before: Settings, after: Settings, rebuilt: bool) -> None:
        """Called after a change of settings. `rebuilt`: True if the experiment changed."""

    def law_changed(self) -> None:
        """Called if a custom law comes or goes."""

    def open_link(self, query: Mapping[str, str]) -> tuple[str, ...]:
        """Apply the rest of a link after the run has begun; messages about what is not possible."""
        return ()

    def curves(self) -> WhatIf | None:
        """Other course of the newest part of the run, for the plots over time, or None."""
        return None

    def reset(self) -> None:
        """Drop state of the run before a reset."""

    def close(self) -> None:
        """Stop all computations."""


P = TypeVar("P", bound=SessionPart)


class SessionParts:
    def __init__(self, session: Any) -> None:
        self._session = session
        self._made: dict[type[SessionPart], SessionPart] = {}
        self._waiting: dict[str, bytes] = {}
        self._recordings: dict[str, Recorded] = {}

    def __iter__(self) -> Iterator[SessionPart]:
        """Parts in the order of their first requests; a part may create others meanwhile."""
        return iter(tuple(self._made.values()))

    def of(self, kind: type[P]) -> P:
        part = self._made.get(kind)
        if part is None:
            part = self._made[kind] = kind(self._session)
            self._restore(part)
        assert isinstance(part, kind)
        return part

    def saved(self) -> dict[str, bytes]:
        """Name → bytes of every part, also of parts not yet requested."""
        made = {part.name: part.saved() for part in self}
        return {name: saved for name, saved in (self._waiting | made).items() if saved}

    def recordings(self) -> dict[str, Recorded]:
        made = {name: recorded for part in self for name, recorded in part.recordings().items()}
        return (self._recordings if self._waiting else {}) | made

    def restore(self, saved: Mapping[str, bytes], recordings: Mapping[str, Recorded] | None = None) -> None:
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
        return any(part.leads for part in self)

    @property
    def hands_off(self) -> bool:
        return any(part.hands_off for part in self)
