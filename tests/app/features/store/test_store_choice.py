"""Choice of a server's store file."""

from contextlib import ExitStack
from pathlib import Path

import pytest

from app.features.store.store_choice import MOST_SERVERS, chosen_store
from app.features.store.store_file import StoreLock, StoreRefused, StoreTaken


def test_choice_of_the_store_file(tmp_path: Path) -> None:
    usual = tmp_path / "state" / "visitors.sqlite"
    with ExitStack() as held:

        def take(port: int) -> tuple[str, StoreLock]:
            path, lock = chosen_store(usual, port)
            return path.name, lock

        name, first = take(8080)
        other, second = take(8081)
        assert (name, other) == ("visitors.sqlite", "visitors-2.sqlite")
        first.release()
        second.release()
        # Chosen by port; another port takes the first free file.
        name, second = take(8081)
        assert name == "visitors-2.sqlite"
        name, third = take(9000)
        assert name == "visitors.sqlite"
        second.release()
        name, fourth = take(8080)
        assert name == "visitors-2.sqlite"
        for lock in (third, fourth):
            held.callback(lock.release)
        for number in range(3, MOST_SERVERS + 1):
            name, lock = take(9000 + number)
            assert name == f"visitors-{number}.sqlite"
            held.callback(lock.release)
        with pytest.raises(
            StoreTaken, match=f"{MOST_SERVERS} servers keep their visitors in .*--store memory"
        ):
            take(9999)
    usual.write_text("a letter", encoding="utf-8")
    with pytest.raises(StoreRefused, match="is not a store of Duet"):
        chosen_store(usual, 7000)
