"""CSV tables of numbers.

Separators are semicolons, tabs, bars, commas or blanks, decimal signs points or commas; the text is UTF-8 or
UTF-16, with any line ends.
"""

import codecs
import csv
import re
from dataclasses import dataclass
from typing import Final, NamedTuple

from controllers.errors import BadInputFile

COMMENTS: Final = ("#", "%", "//")

SEPARATORS: Final = (";", "\t", "|", ",")
"""Search order; the comma may be a decimal sign."""

BLANKS: Final = " "

_BYTE_ORDER_MARKS: Final = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32-le"),
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
"""The mark of UTF-32 begins with that of UTF-16, so it is tested first."""

_LINE_END: Final = re.compile(r"\r\n|\r|\n")
_SEPARATOR_LINE: Final = re.compile(r"\"?sep=(.)\"?", re.IGNORECASE)
_DECIMAL_COMMAS: Final = re.compile(
    r"(?=.*,)[-+\N{MINUS SIGN}]?\d+(,\d+)?(\s+[-+\N{MINUS SIGN}]?\d+(,\d+)?)+"
)
"""Numbers with decimal commas, separated by blanks."""
_LOOKS_NUMERIC: Final = re.compile(r"[-+\N{MINUS SIGN}]?[\d.,]*\d[\d.,]*(e[-+]?\d+)?", re.IGNORECASE)
_LONGEST_SHOWN: Final = 40


class TextRow(NamedTuple):
    """A line with values. `number`: from 1; `cells`: stripped of blanks and quotes."""

    number: int
    cells: tuple[str, ...]


@dataclass(frozen=True)
class TextTable:
    """Rows of a file.

    Attributes:
        separator: one character; `BLANKS` for any number of blanks.
        comment: line number and text of the last comment above the first row.
    """

    separator: str
    rows: tuple[TextRow, ...]
    comment: tuple[int, str] | None = None


def read_text_table(data: bytes, name: str, remedy: str) -> TextTable:
    """Lines with values of a text file.

    Args:
        remedy: end of the error message.

    Raises:
        BadInputFile: not text, or not CSV.
    """
    lines = _LINE_END.split(_decoded(data, name, remedy))
    separator, rows = "", list[TextRow]()
    comment: tuple[int, str] | None = None
    if named := _SEPARATOR_LINE.fullmatch(lines[0].strip(" ")):
        separator, lines[0] = named[1], ""
    for number, line in enumerate(lines, 1):
        text = line.strip()
        mark = next((mark for mark in COMMENTS if text.lstrip('" ').startswith(mark)), None)
        if mark is not None:
            # A spreadsheet pads a comment with separators, and quotes one that has a comma.
            comment = comment if rows else (number, text.lstrip('" ').removeprefix(mark).strip('";,\t '))
        elif any("\udc80" <= char <= "\udcff" or char == "\0" for char in text):
            raise BadInputFile(f"{name}: is not a text file in UTF-8 or UTF-16 (line {number}); {remedy}.")
        elif text:
            separator = separator or separator_of(line)
            try:
                cells = cells_of(line, separator)
            except csv.Error as error:
                raise BadInputFile(f"{name}, line {number}: cannot be read as CSV ({error}).") from None
            if any(cells):
                rows.append(TextRow(number, cells))
    return TextTable(separator or ",", tuple(rows), comment)


def separator_of(line: str) -> str:
    outside = re.sub(r'"[^"]*"', "", line)
    if _DECIMAL_COMMAS.fullmatch(outside.strip()) and "\t" not in outside:
        return BLANKS
    return next((one for one in SEPARATORS if one in outside), BLANKS)


def cells_of(line: str, separator: str) -> tuple[str, ...]:
    """Raises csv.Error if a value has more than 131,072 characters."""
    if separator == BLANKS:
        return tuple(cell.strip('"') for cell in line.split())
    return tuple(
        cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True), ())
    )


def has_decimal_commas(rows: tuple[TextRow, ...]) -> bool:
    """True if a number has a comma."""
    return any("," in cell and _LOOKS_NUMERIC.fullmatch(cell) for row in rows for cell in row.cells)


def number_in_cell(cell: str, decimal_commas: bool, where: str, column: str) -> float:
    """Number in a cell. `where`: file and line, for messages.

    Raises:
        BadInputFile: not a number.
    """
    text = cell.replace("\N{MINUS SIGN}", "-")
    if not (decimal_commas and "." in text):
        try:
            return float(text.replace(",", ".") if decimal_commas else text)
        except ValueError:
            pass
    shown = repr(cell if len(cell) <= _LONGEST_SHOWN else cell[:_LONGEST_SHOWN] + "…")
    if _LOOKS_NUMERIC.fullmatch(cell):
        raise BadInputFile(
            f"{where}: {column} = {shown} is not a number with the file's one decimal sign; write all numbers with a point, or all "
            "with a comma, and without thousands separators."
        )
    raise BadInputFile(f"{where}: {column} = {shown} is not a number.")


def _decoded(data: bytes, name: str, remedy: str) -> str:
    """Bytes that are not UTF-8, as in comments, become lone surrogates."""
    mark, encoding = next((pair for pair in _BYTE_ORDER_MARKS if data.startswith(pair[0])), (b"", "utf-8"))
    body = data[len(mark) :]
    if not mark and len(body) >= 2 and (body[0] == 0) != (body[1] == 0):
        # UTF-16 without its mark: one byte of each ASCII letter is zero.
        encoding = "utf-16-be" if body[0] == 0 else "utf-16-le"
    if encoding == "utf-8":
        return body.decode(encoding, "surrogateescape")
    try:
        return body.decode(encoding)
    except UnicodeDecodeError:
        raise BadInputFile(f"{name}: is not a text file in UTF-8 or UTF-16; {remedy}.") from None
