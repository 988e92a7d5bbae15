"""Files that a command writes: whole, or not at all with one line that says why."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from controllers.errors import BadSetting
from scenes.files import replacing


@contextmanager
def written(path: Path, option: str) -> Iterator[Path]:
    """Yield a draft that replaces `path` once it is written; see `scenes.files.replacing`.

    Args:
        option: the command's option that names it or its folder.

    Raises:
        BadSetting: it cannot be written.
    """
    with writable(path, option), replacing(path) as draft:
        yield draft


@contextmanager
def writable(path: Path, option: str) -> Iterator[None]:
    """Turn an `OSError` about a path into the `BadSetting` of the option that names it."""
    try:
        yield
    except OSError as error:
        raise BadSetting(f"{option} = {path}: cannot be written ({error.strerror or error}).") from None
