"""Options of the store: refusals, and one file chosen and locked for all processes."""

from contextlib import ExitStack
from pathlib import Path

import pytest

from app.features.store import STORE
from app.features.store.session_store import SessionStore
from app.features.store.store_file import StoreLock, StoreTaken
from app.features.store.store_options import MEMORY, StoreOptions
from app.hosting.serve_options import ServeOptions
from tests.app.cli.test_commands import refused


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("--store-size 0.5", "--store-size must be at least 1 MB."),
        ("--keep 0", "--keep = 0 h is not possible; give hours up to 8784, or --store memory."),
        ("--keep nan", "--keep = nan h is not possible"),
    ],
)
def test_one_line_says_what_is_wrong(capsys: pytest.CaptureFixture[str], arguments: str, said: str) -> None:
    assert said in refused(capsys, "serve", *arguments.split())


def made(options: StoreOptions) -> SessionStore:
    assert STORE.store is not None
    store = STORE.store(ServeOptions(features=(options,)))
    assert isinstance(store, SessionStore)
    return store


def test_the_server_locks_the_file_and_its_processes_open_it_without(tmp_path: Path) -> None:
    path = tmp_path / "store"
    with ExitStack() as until:
        held = StoreOptions(store=str(path)).held(8080, until)
        assert held == StoreOptions(store=str(path), file=path, locked=True)
        for store in (made(held), made(held)):
            assert store.lasting
            store.close()
        with pytest.raises(StoreTaken):
            StoreLock(path)
        with pytest.raises(StoreTaken):
            made(StoreOptions(file=path))
    # A process started without the command takes the lock itself.
    store = made(StoreOptions(file=path))
    with pytest.raises(StoreTaken):
        StoreLock(path)
    store.close()
    StoreLock(path).release()


def test_in_memory_nothing_is_locked_and_nothing_lasts() -> None:
    with ExitStack() as until:
        options = StoreOptions(store=MEMORY)
        assert options.held(8080, until) is options and not made(options).lasting


def test_the_start_names_an_unusual_store_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    with ExitStack() as until:
        first = StoreOptions().held(8080, until)
        second = StoreOptions().held(8081, until)
    folder = tmp_path / "lwr-duet"
    assert (first.file, second.file) == (folder / "visitors.sqlite", folder / "visitors-2.sqlite")
    assert first.said_at_start("", 8080, 1) == ()
    assert second.said_at_start("", 8081, 1) == (
        f"This Duet keeps its visitors in {second.file}: others have their own files there.",
    )
