"""Search for a visitor's record without a frame loop."""

from collections.abc import Mapping

from app.hosting.parking import Parking
from app.hosting.visitor_record import VisitorRecord


def find(store: Parking, query: Mapping[str, str]) -> VisitorRecord | None:
    search = store.recall(query)
    while True:
        try:
            next(search)
        except StopIteration as end:
            return end.value
