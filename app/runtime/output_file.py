"""Files that a command writes: whole or not at all, or one line that says why not."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from controllers.errors import BadSetting
from scenes.files import replacing


@contextmanager
def written(path: Path, option: str) -> Iterator[Path]:
    """Give a path to write to, which is moved to `path` when all is written; see `scenes.files.replacing`.

    Args:
        path: of the file.
        option: that named the file or its folder.

    Raises:
        BadSetting: it cannot be written.
    """
    try:
        with replacing(path) as draft:
            yield draft
    except OSError as error:
        raise BadSetting(f"{option} = {path}: cannot be written ({error.strerror or error}).") from None
