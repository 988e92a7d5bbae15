"""TOML blocks of a lesson file, with line numbers."""

import math
import re
import sys
import tomllib
from collections.abc import Callable, Iterable
from typing import Any, Final, TypeGuard, TypeVar

from app.features.lessons.markdown import DataBlock, Fault, FaultLog
from controllers.errors import BadSetting

T = TypeVar("T")

LARGEST: Final = 1e6

NEEDED: Final[Any] = object()

_AT: Final = re.compile(r"\(at line (\d+), column (\d+)\)|\(at end of document\)")
_HEADER: Final = re.compile(r"^\s*\[{1,2}\s*([^\[\]]+?)\s*\]{1,2}\s*(#.*)?$")


class Table:
    """A table. Reading a key removes it; `close` reports the rest. `path`: "" for the whole block."""

    def __init__(self, data: dict[str, Any], lines: list[tuple[int, str]], line: int, path: str = "") -> None:
        self._data, self._lines, self._line, self._path = dict(data), lines, line, path
        self._known: list[str] = []

    def line_of(self, key: str) -> int:
        written = re.compile(rf"(^|[{{,\s])\s*[\"']?{re.escape(key)}[\"']?\s*(=|\.)")
        header = re.compile(rf"^\s*\[{{1,2}}\s*({re.escape(self._path)}\.)?{re.escape(key)}\b")
        for number, line in self._lines:
            if written.search(line) or header.match(line):
                return number
        return self._line

    def fault(self, key: str, message: str) -> Fault:
        return Fault(self.line_of(key), message)

    def has(self, key: str) -> bool:
        return key in self._data

    def any(self, key: str, default: Any = None) -> Any:
        self._known.append(key)
        if key in self._data:
            return self._data.pop(key)
        if default is NEEDED:
            where = f" to {self._path}" if self._path else ""
            raise self.fault(key, f"{key} is missing; add it{where}.")
        return default

    def text(self, key: str, default: str = NEEDED, most: int = 200) -> str:
        value = self.any(key, default)
        if not isinstance(value, str):
            raise self.fault(key, f"{key} = {quoted_value(value)} is not a text; write it in quotes.")
        if len(value) > most:
            raise self.fault(key, f"{key} is too long; use at most {most} characters.")
        return value

    def choice(self, key: str, choices: Iterable[str], default: str = NEEDED) -> str:
        value, choices = self.text(key, default), tuple(choices)
        if value not in choices:
            raise self.fault(
                key, f"{key} = {quoted_value(value)} is not possible; choose from {', '.join(choices)}."
            )
        return value

    def number(
        self, key: str, default: float = NEEDED, low: float = -LARGEST, high: float = LARGEST
    ) -> float:
        value = self.any(key, default)
        if not is_number(value) or not low <= value <= high:
            raise self.fault(
                key, f"{key} = {quoted_value(value)} is not possible; give a number from {low:g} to {high:g}."
            )
        return float(value)

    def whole(self, key: str, default: int = NEEDED, low: int = 0, high: int = 1000) -> int:
        value = self.number(key, default, low, high)
        if value != int(value):
            raise self.fault(key, f"{key} = {value:g} is not a whole number; give one from {low} to {high}.")
        return int(value)

    def flag(self, key: str) -> bool:
        value = self.any(key, False)
        if not isinstance(value, bool):
            raise self.fault(key, f"{key} = {quoted_value(value)} is neither true nor false.")
        return value

    def numbers(self, key: str, count: int | None = None) -> tuple[float, ...]:
        value = self.any(key, ())
        if not isinstance(value, (list, tuple)) or not all(is_number(x) and abs(x) <= LARGEST for x in value):
            raise self.fault(
                key, f"{key} = {quoted_value(value)} is not a list of numbers; write it like [0.0, 1.0, 0.0]."
            )
        if count is not None and len(value) != count:
            raise self.fault(key, f"{key} has {len(value)} numbers; give {count}.")
        return tuple(float(x) for x in value)

    def words(self, key: str, choices: Iterable[str], most: int) -> tuple[str, ...]:
        value, choices = self.any(key, ()), tuple(choices)
        if isinstance(value, str):
            value = [value]
        if not isinstance(value, (list, tuple)) or not all(isinstance(x, str) for x in value):
            raise self.fault(
                key, f'{key} = {quoted_value(value)} is not a list of words; write it like ["a", "b"].'
            )
        for word in value:
            if word not in choices:
                raise self.fault(
                    key, f"{key}: there is no {quoted_value(word)}; choose from {', '.join(choices)}."
                )
        if len(set(value)) < len(value):
            raise self.fault(key, f"{key} names something twice; name each once.")
        if len(value) > most:
            raise self.fault(key, f"{key} names {len(value)}; at most {most} are in view at once.")
        return tuple(value)

    def table(self, key: str) -> "Table | None":
        value = self.any(key)
        if value is None:
            return None
        if not isinstance(value, dict):
            raise self.fault(
                key,
                f"{key} = {quoted_value(value)} is not a table; write it like {key} = {{ … }} or [{self._child(key)}].",
            )
        return self._sub(key, value, 0)

    def tables(self, key: str) -> "list[Table]":
        value = self.any(key, ())
        if (
            isinstance(value, dict)
            or not isinstance(value, (list, tuple))
            or not all(isinstance(x, dict) for x in value)
        ):
            raise self.fault(
                key,
                f"{key} = {quoted_value(value)} is not a list of tables; begin each with [[{self._child(key)}]].",
            )
        return [self._sub(key, entry, i) for i, entry in enumerate(value)]

    def rest(self) -> dict[str, Any]:
        rest, self._data = self._data, {}
        return rest

    def close(self) -> None:
        log, where = FaultLog(), f" in {self._path}" if self._path else ""
        known = ", ".join(dict.fromkeys(self._known))
        log.found += [
            self.fault(key, f"there is no key {quoted_value(key)}{where}; choose from {known}.")
            for key in self._data
        ]
        log.close()

    def checked(self, key: str, check: Callable[[], T]) -> T:
        try:
            return check()
        except BadSetting as error:
            raise self.fault(key, str(error)) from None

    def _child(self, key: str) -> str:
        return f"{self._path}.{key}" if self._path else key

    def _sub(self, key: str, data: dict[str, Any], index: int) -> "Table":
        path, found, inside, lines = self._child(key), -1, False, list[tuple[int, str]]()
        for number, line in self._lines:
            header = _HEADER.match(line)
            if header is not None:
                name = re.sub(r"\s*\.\s*", ".", header[1])
                found += name == path
                inside = found == index and (name == path or name.startswith(path + "."))
            if inside:
                lines.append((number, line))
        if not lines:
            at = self.line_of(key)
            lines = [(number, line) for number, line in self._lines if number >= at]
            return Table(data, lines, at, path)
        return Table(data, lines, lines[0][0], path)


def is_number(value: object) -> TypeGuard[int | float]:
    """True for a number that fits a float and is not nan."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= sys.float_info.max or (isinstance(value, float) and math.isinf(value))


def quoted_value(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "…"


def read_block(block: DataBlock, name: str = "block") -> Table:
    """Parse a block.

    Raises:
        Fault: not TOML.
    """
    text = "\n".join(block.lines)
    try:
        data = tomllib.loads(text + "\n")
    except RecursionError:
        raise Fault(block.line, f"the {name} is nested too deeply; write it more simply.") from None
    except ValueError as error:
        found = _AT.search(str(error))
        line = block.line + (int(found[1]) - 1 if found and found[1] else max(len(block.lines) - 1, 0))
        what = _AT.sub("", str(error)).strip()
        raise Fault(line, f"the {name} is not TOML here: {what}.") from None
    return Table(data, list(enumerate(block.lines, block.line)), block.line)
