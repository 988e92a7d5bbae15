"""Reads the store file of a server."""

from contextlib import closing
from pathlib import Path

from app.features.store.record_bytes import visitor_from_bytes
from app.features.store.store_file import StoreFile
from app.hosting.visitor_record import VisitorRecord


def kept(store: Path, tab: str) -> VisitorRecord | None:
    """Record of a tab in the file of a server, which may be running."""
    with closing(StoreFile(store, 10**9)) as file:
        found = file.read(tab)
        return None if found is None else visitor_from_bytes(found[1])
