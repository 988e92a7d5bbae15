"""Files that the user names: what is no file is neither waited for nor replaced, and no half of one is left."""

import errno
import os
import threading
from pathlib import Path

import pytest

from scenes.files import path_inside, read_file, replacing

posix = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names")


@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError, UnicodeError])
def test_what_is_interrupted_leaves_what_was_there(tmp_path: Path, error: type[BaseException]) -> None:
    path = tmp_path / "file"
    for before in (None, "old"):
        if before is not None:
            path.write_text(before, encoding="utf-8")
        with pytest.raises(error), replacing(path) as draft:
            draft.write_text("half", encoding="utf-8")
            assert draft.parent == path.parent and draft != path
            raise error
        assert {p.name: p.read_text(encoding="utf-8") for p in tmp_path.iterdir()} == ({"file": before} if before else {})
    with replacing(path) as draft:
        draft.write_text("new", encoding="utf-8")
        assert path.read_text(encoding="utf-8") == "old"
    assert path.read_text(encoding="utf-8") == "new" and list(tmp_path.iterdir()) == [path]


@posix
def test_links_devices_and_pipes_stay_what_they_are(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("folder/file")
    (tmp_path / "folder").mkdir()
    with replacing(tmp_path / "link") as draft:
        draft.write_text("through", encoding="utf-8")
    assert (tmp_path / "link").is_symlink() and (tmp_path / "folder/file").read_text(encoding="utf-8") == "through"
    with replacing(Path(os.devnull)) as draft:
        assert draft == Path(os.devnull)
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    # No process reads it.
    with pytest.raises(OSError), replacing(pipe):
        raise AssertionError("it must not come to that")
    read: list[str] = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_text(encoding="utf-8")))
    reader.start()
    while not read and reader.is_alive():
        try:
            with replacing(pipe) as draft:
                draft.write_text("words", encoding="utf-8")
            break
        except OSError:
            # The reader has not come yet.
            continue
    reader.join()
    assert read == ["words"] and pipe.is_fifo()


def test_files_and_names_stay_in_their_folder(tmp_path: Path) -> None:
    with pytest.raises(IsADirectoryError), replacing(tmp_path):
        raise AssertionError("it must not come to that")
    (tmp_path / "loop").symlink_to("loop")
    assert path_inside(tmp_path, "a/../b") == Path(os.path.realpath(tmp_path / "b"))
    assert path_inside(tmp_path, "loop") is not None
    assert path_inside(tmp_path, "../b") is None and path_inside(tmp_path, "b\0") is None and path_inside(tmp_path, "/b") is None
    path = tmp_path / "file"
    path.write_bytes(b"\r\n\x1a0")
    assert read_file(path, 4) == b"\r\n\x1a0"
    with pytest.raises(OSError, match="larger") as error:
        read_file(path, 3)
    assert error.value.errno == errno.EFBIG
    for name in ("none", "a\0b"):
        with pytest.raises(FileNotFoundError):
            read_file(tmp_path / name, 3)
    with pytest.raises(OSError, match="a folder"):
        read_file(tmp_path, 3)
