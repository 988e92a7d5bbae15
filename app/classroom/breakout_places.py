"""Who explores by themselves: so many at once as the machine carries, and everybody's own settings for the next time."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from app.lessons.session.saved import SavedLesson
from app.settings import Settings

HOLD: Final = 60.0
"""How long a place is kept for a student who is gone [s]: a reload, a dropped connection."""

MOST: Final = 300
"""Students whose settings are kept; the oldest make room."""


@dataclass(frozen=True)
class Kept:
    """What a student explored with.

    Attributes:
        settings: of the session, with all that was changed in it.
        saved: progress in the lessons; None if none was ever opened.
    """

    settings: Settings
    saved: SavedLesson | None


class Places:
    """The sessions of their own that a class may have. Students are known by the word that their tab keeps.

    Args:
        most: how many at once.
    """

    def __init__(self, most: int) -> None:
        self.most = most
        self._holders: dict[str, float] = {}
        self._kept: dict[str, Kept] = {}

    @property
    def taken(self) -> int:
        """How many places are taken."""
        return len(self._holders)

    def holds(self, who: str) -> bool:
        """Return whether a student has a place; may be asked from any thread."""
        return who in self._holders

    def give(self, here: Iterable[str], now: float) -> None:
        """Give a place to everybody who is here, in this order, as long as there are any; take it from who is gone for long.

        Args:
            here: words of those who want one.
            now: the clock [s].
        """
        here = list(dict.fromkeys(here))
        for who in here:
            if who in self._holders:
                self._holders[who] = now
        for who, seen in list(self._holders.items()):
            if now - seen > HOLD:
                del self._holders[who]
        for who in here:
            if len(self._holders) >= self.most:
                return
            self._holders.setdefault(who, now)

    def take_all(self) -> None:
        """Call everybody back."""
        self._holders.clear()

    def keep(self, who: str, kept: Kept) -> None:
        """Keep what a student explored with."""
        self._kept.pop(who, None)
        self._kept[who] = kept
        while len(self._kept) > MOST:
            del self._kept[next(iter(self._kept))]

    def kept(self, who: str) -> Kept | None:
        """Return what a student explored with the last time; None if never."""
        return self._kept.get(who)
