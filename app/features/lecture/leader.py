"""Lead of a lecture."""

from collections import deque
from collections.abc import Callable, Mapping
from time import monotonic
from typing import Final

from app.features.classroom.class_record import NEW_CLASS, ClassRecord
from app.features.lecture.audiences import SCREEN
from app.hosting.teacher_key import is_teacher
from app.hosting.visitor_record import tab_id

HOLD: Final = 60.0
"""Time for which a disconnected tab keeps the lead, without a key [s]."""

MOST: Final = 1000
"""Most students' tabs in memory."""


class Leader:
    """Browsers with the key may lead, or without a key the first tab.

    After `HOLD` only a tab that is new in the class can take over, so students cannot wait for it. `admits`
    and `gone` belong to the network's thread. `record`: of a class to resume; its leader has just
    disconnected.
    """

    def __init__(
        self, key: str | None, record: ClassRecord = NEW_CLASS, clock: Callable[[], float] = monotonic
    ) -> None:
        self._key, self._clock = key, clock
        self._holder, self._since = record.leader, clock()
        self._client_ids: set[int] = set()
        self._students: deque[str | None] = deque(record.students, maxlen=MOST)

    def admits(self, client_id: int, query: Mapping[str, str]) -> bool:
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
        return self._holder, tuple(tab for tab in list(self._students) if tab is not None)

    def gone(self, client_id: int) -> None:
        if client_id in self._client_ids:
            self._client_ids.remove(client_id)
            self._since = self._clock()

    def holds(self, client_id: int) -> bool:
        """True if this browser may lead; thread-safe."""
        return client_id in self._client_ids
