"""A law's file, edited on the page."""

import hashlib
import shlex
from pathlib import Path
from typing import Final, NamedTuple

from app.features.custom_law.custom_law import read_law
from controllers.errors import BadInputFile
from scenes.files import readable, replacing

MOST: Final = 48_000
"""Largest edited text [bytes]; it must pass the gate as one message."""


class Version(NamedTuple):
    """Content of a file.

    Attributes:
        text: every line ends with one character.
        sha256: hexadecimal, of the file; "" for a new one.
    """

    text: str
    sha256: str
    newline: str = "\n"


class ChangedMeanwhile(Exception):
    """Another editor changed the file. `version`: its current content."""

    def __init__(self, version: Version) -> None:
        super().__init__(version.sha256)
        self.version = version


def first_text(path: Path) -> str:
    template = Path(__file__).with_name("template.py").read_text(encoding="utf-8")
    return template.replace("my_law.py", shlex.quote(readable(path.name)))


def read_version(path: Path) -> Version:
    """Content of a file; first text for a missing one.

    Raises:
        BadInputFile: it cannot be read or edited.
    """
    if not path.exists():
        return Version(first_text(path), "")
    content = read_law(path)
    try:
        whole = content.decode("utf-8")
    except UnicodeDecodeError:
        raise BadInputFile("{path}: is not UTF-8; save it as UTF-8 to edit it here.", path=path) from None
    check_text(path, whole)
    text = whole.replace("\r\n", "\n").replace("\r", "\n")
    return Version(text, hashlib.sha256(content).hexdigest(), "\r\n" if "\r\n" in whole else "\n")


def check_text(path: Path, text: str) -> None:
    """Raise BadInputFile if a text cannot be edited here."""
    if len(text.encode()) > MOST:
        raise BadInputFile(
            "{path}: is larger than {size} kB, too large to be edited here.", path=path, size=MOST // 1000
        )
    if "\0" in text:
        raise BadInputFile("{path}: holds a zero byte, which no Python file has.", path=path)


def save_text(path: Path, text: str, base: str) -> Version:
    """Write a text atomically.

    Args:
        base: `sha256` of the edited version.

    Raises:
        ChangedMeanwhile: the file has another version and text.
        BadInputFile: the text does not fit, or the file cannot be read or written.
    """
    check_text(path, text)
    now = read_version(path)
    if now.sha256 != base and now.text != text:
        raise ChangedMeanwhile(now)
    content = text.replace("\n", now.newline).encode()
    try:
        with replacing(path) as draft:
            draft.write_bytes(content)
    except OSError as error:
        raise BadInputFile(
            "{path}: cannot be written ({reason}).", path=path, reason=error.strerror
        ) from None
    return Version(text, hashlib.sha256(content).hexdigest(), now.newline)
