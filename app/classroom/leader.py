"""Who may lead a lecture: those who bring the key; without a key one tab, the first."""

from collections import deque
from collections.abc import Mapping
from time import monotonic
from typing import Final

from app.hosting.resume import word_of
from app.hosting.teacher_key import is_teacher

HOLD: Final = 60.0
"""How long the lead is kept without a key for a tab whose connection has dropped [s]."""

MOST: Final = 1000
"""Words of students that are remembered."""


class Leader:
    """Without a key the lead stays with the word that the first tab keeps, also for `HOLD` seconds after its connection has dropped.

    Then a tab that is opened afterwards gets it, such as the teacher's on another computer. A tab that was in the class before never
    does, so that no student's page comes to lead by waiting, or by a connection that drops.
    `admits` and `gone` belong to the network's thread.

    Args:
        key: the teacher's; None for none.
    """

    def __init__(self, key: str | None) -> None:
        self._key = key
        self._holder: str | None = None
        self._numbers: set[int] = set()
        self._since = 0.0
        self._students: deque[str | None] = deque(maxlen=MOST)

    def admits(self, number: int, query: Mapping[str, str], now: float | None = None) -> bool:
        """Return whether a browser that connects may lead.

        Args:
            number: of its connection.
            query: of its link.
            now: the clock [s].
        """
        word = word_of(query)
        if "screen" in query:
            return False
        if self._key is not None:
            admitted = is_teacher(self._key, query)
        else:
            admitted = self._holder in (None, word or f"tab {number}") or self._is_heir(word, monotonic() if now is None else now)
        if admitted:
            self._holder = word or f"tab {number}"
            self._numbers.add(number)
        elif word not in self._students:
            self._students.append(word)
        return admitted

    def _is_heir(self, word: str | None, now: float) -> bool:
        vacant = not self._numbers and now - self._since > HOLD
        return vacant and word is not None and word not in self._students

    def gone(self, number: int, now: float | None = None) -> None:
        """Take note that a connection is gone. `now`: the clock [s]."""
        if number in self._numbers:
            self._numbers.remove(number)
            self._since = monotonic() if now is None else now

    def holds(self, number: int) -> bool:
        """Return whether the browser of a connection may lead; may be asked from any thread."""
        return number in self._numbers
