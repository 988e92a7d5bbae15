"""Which browsers may lead a lecture: those with the key; without a key the first tab."""

from collections import deque
from collections.abc import Callable, Mapping
from time import monotonic
from typing import Final

from app.features.classroom.class_record import NEW_CLASS, ClassRecord
from app.features.lecture.audiences import SCREEN
from app.hosting.teacher_key import is_teacher
from app.hosting.visitor_record import tab_id

HOLD: Final = 60.0
"""How long the lead is held, without a key, for a tab that has disconnected [s]."""

MOST: Final = 1000
"""Students' tabs that are remembered."""


class Leader:
    """Decides which browsers may lead: those with the key; without a key the first tab.

    That tab holds the lead for `HOLD` after it has disconnected. Then only a tab that was not in the class before gets it, so that no
    student comes to lead by waiting. `admits` and `gone` belong to the network's thread.

    Args:
        key: the teacher's; None if the server has no key.
        record: of the class, which goes on from there as if the tab that leads had just disconnected.
        clock: returns the time [s].
    """

    def __init__(self, key: str | None, record: ClassRecord = NEW_CLASS, clock: Callable[[], float] = monotonic) -> None:
        self._key, self._clock = key, clock
        self._holder, self._since = record.leader, clock()
        self._client_ids: set[int] = set()
        self._students: deque[str | None] = deque(record.students, maxlen=MOST)

    def admits(self, client_id: int, query: Mapping[str, str]) -> bool:
        """True if a browser that connects with a query may lead."""
        tab = tab_id(query)
        name = tab or f"tab {client_id}"
        if SCREEN in query:
            return False
        vacant = not self._client_ids and self._clock() - self._since > HOLD
        leads = self._holder in (None, name) or (vacant and tab is not None and tab not in self._students)
        admitted = leads if self._key is None else is_teacher(self._key, query)
        if admitted:
            self._holder = name
            self._client_ids.add(client_id)
        elif tab not in self._students:
            self._students.append(tab)
        return admitted

    @property
    def tabs(self) -> tuple[str | None, tuple[str, ...]]:
        """Return the ids of the tab that leads, and of the students' tabs."""
        return self._holder, tuple(tab for tab in list(self._students) if tab is not None)

    def gone(self, client_id: int) -> None:
        """Note that a browser has disconnected."""
        if client_id in self._client_ids:
            self._client_ids.remove(client_id)
            self._since = self._clock()

    def holds(self, client_id: int) -> bool:
        """True if a connected browser may lead; from any thread."""
        return client_id in self._client_ids
