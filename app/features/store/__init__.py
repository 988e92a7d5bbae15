from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.feature import Feature

if TYPE_CHECKING:
    from app.features.store.store_options import StoreOptions
    from app.hosting.parking import Parking
    from app.hosting.serve_options import ServeOptions


def _options() -> "type[StoreOptions]":
    from app.features.store.store_options import StoreOptions

    return StoreOptions


def _store(options: "ServeOptions") -> "Parking":
    from app.features.store.record_writer import RecordWriter
    from app.features.store.session_store import SessionStore

    mine = options.of(_options())
    file = (
        None
        if mine.file is None
        else RecordWriter(mine.file, mine.seconds, mine.most_bytes, owned=not mine.locked)
    )
    return SessionStore(mine.seconds, file=file)


IN_MEMORY: Final = ("--store", "memory")

STORE: Final = Feature("store", texts=Path(__file__).parent, options=_options, store=_store)
