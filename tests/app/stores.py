"""Finds a visitor's record without a frame loop."""

from collections.abc import Mapping

from app.hosting.session_store import SessionStore
from app.hosting.visitor_record import VisitorRecord


def find(store: SessionStore, query: Mapping[str, str]) -> VisitorRecord | None:
    search = store.recall(query)
    while True:
        try:
            next(search)
        except StopIteration as end:
            return end.value
