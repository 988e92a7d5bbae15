"""Messages about refused robot files, as an approved text."""

import re
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from app.settings import Language
from controllers.errors import BadInputFile
from tests.app.features.said import lines_of

Refused = Mapping[str, str | bytes]

LIBRARIES = r"(XML [^(\n]*|\.(?:obj|dae): [^(\n]*)\(.*\)"
"""The messages of the XML and mesh parsers differ by version."""


def refusals(files: Refused, read: Callable[[str | bytes], object]) -> dict[str, str]:
    """Case → the sentence for its file."""
    said = dict[str, str]()
    for case, text in files.items():
        with pytest.raises(BadInputFile) as error:
            read(text)
        said[case] = str(error.value)
        assert "\n" not in said[case] and said[case].endswith("."), case
    return said


def refusal_lines(said: Mapping[str, str], folder: Path, language: Language) -> str:
    text = lines_of(said, language).replace(str(folder), "FOLDER").replace("x" * 5000, "xxx")
    return re.sub(LIBRARIES, r"\1(…)", text)
