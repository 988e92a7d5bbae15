"""Default store file, one for each server of a computer."""

from pathlib import Path
from typing import Final

from app.features.store.store_file import StoreLock, StoreTaken

MOST_SERVERS: Final = 32


def chosen_store(usual: Path, port: int) -> tuple[Path, StoreLock]:
    """Choose and lock the file of the last server at this port, since browsers return to an address, or the
    first free one of `visitors.sqlite`, `visitors-2.sqlite`, ….

    Raises:
        StoreTaken: all files belong to running servers.
        StoreRefused: an existing file is not a store.
        OSError: there can be no file.
    """
    files = [usual, *(usual.with_stem(f"{usual.stem}-{number}") for number in range(2, MOST_SERVERS + 1))]
    # The sort is stable: the others stay in their order.
    for path in sorted(files, key=lambda path: StoreLock.last_port(path) != port):
        try:
            lock = StoreLock(path)
        except StoreTaken:
            continue
        lock.note_port(port)
        return path, lock
    raise StoreTaken(
        f"{MOST_SERVERS} servers keep their visitors in {usual.parent} already; end one of them, or give this one --store memory."
    )
