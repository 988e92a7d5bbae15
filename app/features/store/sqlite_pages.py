"""Reads intact rows of a damaged SQLite file, page by page. Imports nothing slow.

Format: https://www.sqlite.org/fileformat2.html, sections 1.6 (pages), 2.1 (rows) and 4.1 (the log).
"""

import struct
import zlib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Final

PAGE: Final = 4096
"""Page size [bytes]."""

_TABLE: Final = 13
"""First byte of a page with rows of a table."""

_MOST: Final = PAGE - 35
_LEAST: Final = (PAGE - 12) * 32 // 255 - 23
"""Most bytes of a row in its own page, and least if it continues in others."""

_NUMBERS: Final = (0, 1, 2, 3, 4, 6, 8, 8, 0, 0)
"""Bytes of a number by its kind: 0 has no value, 7 is real, 8 and 9 are the numbers 0 and 1."""

_REAL: Final = 7

SqliteValue = float | str | bytes


def is_whole(data: bytes) -> bool:
    """True if data match their check sum."""
    return zlib.crc32(data[4:]) == _number(data[:4])


class Pages:
    """Pages of a file, and of its log's complete transactions; raises `OSError`."""

    def __init__(self, path: Path) -> None:
        self._content, self._logged = path.read_bytes(), _logged(path.with_name(path.name + "-wal"))
        self._count = max([-(-len(self._content) // PAGE), *self._logged])

    def page(self, number: int) -> bytes:
        """Page `number` (1-based); short where the file ends early."""
        logged = self._logged.get(number)
        return self._content[(number - 1) * PAGE : number * PAGE] if logged is None else logged

    def rows(self) -> Iterator[tuple[SqliteValue, ...]]:
        """Readable rows of all tables; values may be wrong."""
        for number in range(1, self._count + 1):
            page = self.page(number)
            if page[:1] == bytes([_TABLE]):
                for place in range(8, 8 + 2 * _number(page[3:5]), 2):
                    with suppress(IndexError, ValueError, struct.error):
                        yield _values(self._row(page, _number(page[place : place + 2])))

    def _row(self, page: bytes, place: int) -> bytes:
        size, place = _varint(page, place)
        _, place = _varint(page, place)
        if size > PAGE * self._count:
            raise ValueError("the row is longer than the file")
        here = size if size <= _MOST else _LEAST + (size - _LEAST) % (PAGE - 4)
        here = here if here <= _MOST else _LEAST
        row, following = bytearray(page[place : place + here]), _number(page[place + here : place + here + 4])
        while len(row) < size:
            further = self.page(following) if following else b""
            if len(further) < PAGE:
                raise ValueError("the row is cut off")
            row += further[4 : 4 + size - len(row)]
            following = _number(further[:4])
        return bytes(row)


def _number(data: bytes) -> int:
    return int.from_bytes(data, "big")


def _varint(data: bytes, place: int) -> tuple[int, int]:
    """Value, and offset after it."""
    value = 0
    for end in range(place, place + 8):
        value = value << 7 | data[end] & 127
        if data[end] < 128:
            return value, end + 1
    return value << 8 | data[place + 8], place + 9


def _values(row: bytes) -> tuple[SqliteValue, ...]:
    end, place = _varint(row, 0)
    content = end
    values: list[SqliteValue] = []
    while place < end:
        kind, place = _varint(row, place)
        size = (kind - 12) // 2 if kind >= 12 else _NUMBERS[kind]
        data = row[content : content + size]
        content += size
        if len(data) < size:
            raise ValueError("a value is cut off")
        if kind >= 12:
            values.append(data.decode() if kind % 2 else data)
        elif kind == _REAL:
            values.append(struct.unpack(">d", data)[0])
        else:
            values.append(int.from_bytes(data, "big", signed=True) if size else int(kind == 9))
    return tuple(values)


def _logged(path: Path) -> dict[int, bytes]:
    done: dict[int, bytes] = {}
    begun: dict[int, bytes] = {}
    log = path.read_bytes() if path.exists() else b""
    for frame in range(32, len(log) - 23 - PAGE, 24 + PAGE):
        if log[frame + 8 : frame + 16] != log[16:24]:
            # The rest is of an earlier round.
            break
        begun[_number(log[frame : frame + 4])] = log[frame + 24 : frame + 24 + PAGE]
        if any(log[frame + 4 : frame + 8]):
            done |= begun
            begun.clear()
    return done
