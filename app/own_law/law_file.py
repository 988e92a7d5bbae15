"""A student's file, as it is read and called in its own process, and what is wrong with it in the student's words."""

import inspect
import traceback
from collections.abc import Callable
from importlib.util import decode_source
from time import perf_counter
from types import CodeType
from typing import Any, Final

import numpy as np

from app.own_law.seen import Array, Situation, one_joint

FILENAME: Final = "<own law>"
"""What the file is called in tracebacks: plain letters, whatever its real name, so that every tool can print it."""

LONGEST: Final = 300
"""Characters of a message."""

CURVE: Final = 0.02
"""Time for a whole curve of rates [s]; what is missing then is left out of the picture."""

BALLAST: Final = 4 * 2**20
"""Memory kept for saying that there is no more [bytes]."""


class Wrong(Exception):
    """Something is wrong with the file.

    Args:
        text: what, and what was expected.
        line: where; None if unknown.
    """

    def __init__(self, text: str, line: int | None = None) -> None:
        super().__init__(text)
        self.text = text if len(text) <= LONGEST else text[: LONGEST - 1] + "…"
        self.line = line


class LawFile:
    """The functions of a file.

    Args:
        path: for `__file__`.
        text: the file as it is, in whatever encoding it declares.
        memory: what it may take, for the message when it wants more [bytes].

    Attributes:
        wants_all_pairs: whether it reads `rows`, `distances` and `approaches`.
        has_activation: whether it has a function `activation`.

    Raises:
        Wrong: it does not compile, it fails while it is read, or there is no function `law` of one argument.
    """

    def __init__(self, path: str, text: bytes, memory: int) -> None:
        self._memory, self._text = memory, text
        self._ballast: bytearray | None = bytearray(BALLAST)
        try:
            code = compile(text, FILENAME, "exec", dont_inherit=True)
        except SyntaxError as error:
            raise Wrong(*_syntax(error)) from None
        except ValueError as error:
            raise Wrong(f"this is no Python text: {error}") from None
        # Not "__main__": what stands under `if __name__ == "__main__"` is for trying it out by hand.
        names: dict[str, Any] = {"__name__": "own_law", "__file__": path}
        try:
            exec(code, names)
        except BaseException as error:
            raise self._explained(error, None) from None
        self._law = self._function(names, "law", "situation")
        if self._law is None:
            raise Wrong("there is no function law(situation); write one that returns joint velocities.")
        self._activation = self._function(names, "activation", "distance")
        self.has_activation = self._activation is not None
        self.wants_all_pairs = bool(names.get("WANTS_ALL_PAIRS", True))

    def _function(self, names: dict[str, Any], name: str, argument: str) -> Callable[[Any], Any] | None:
        """Return a function of the file that takes one argument; None if there is none of this name."""
        function = names.get(name)
        if function is None:
            return None
        if not callable(function):
            raise Wrong(f"{name} is a {type(function).__name__}; it must be a function: def {name}({argument}).")
        try:
            inspect.signature(function).bind(None)
        except TypeError as error:
            raise Wrong(
                f"{name} must take one argument, {name}({argument}); as it stands: {error}.", _line_of(function)
            ) from None
        except ValueError:
            pass  # Written in C: it will turn out when it is called.
        return function

    def velocities(self, situation: Situation) -> tuple[Array, float]:
        """Return q̇ (n,) [rad/s] and the time that it took [s].

        Raises:
            Wrong: an exception, or something else than n finite numbers.
        """
        law, n = self._law, len(situation.row)
        assert law is not None
        try:
            begin = perf_counter()
            result = law(situation)
            seconds = perf_counter() - begin
            return self._checked(result, n), seconds
        except Wrong:
            raise
        except BaseException as error:
            raise self._explained(error, _line_of(law)) from None

    def _checked(self, result: Any, n: int) -> Array:
        """Return what `law` returned as an array (n,) of finite numbers."""
        line = _line_of(self._law)
        expected = f"{n} joint velocities [rad/s], an array of shape ({n},)"
        if result is None:
            raise Wrong(f"law returned None; expected {expected}. Is a `return` missing?", line)
        try:
            array = np.asarray(result)
            number = array.dtype.kind in "fiub"
        except ValueError:
            raise Wrong(f"law returned a {type(result).__name__} of uneven parts; expected {expected}.", line) from None
        if not number:
            kind = "complex numbers" if array.dtype.kind == "c" else f"a {type(result).__name__} that holds no plain numbers"
            raise Wrong(f"law returned {kind}; expected {expected}.", line)
        if array.shape != (n,):
            what = "a single number" if array.shape == () else f"an array of shape {array.shape}"
            raise Wrong(f"law returned {what}; expected {expected}.", line)
        velocities = array.astype(np.float64, copy=False)
        finite = np.isfinite(velocities)
        if np.count_nonzero(finite) < n:
            joint = int(np.argmin(finite))
            raise Wrong(f"law returned {velocities[joint]} for joint {joint + 1} of {n}; expected finite numbers.", line)
        return velocities

    def activation(self, distance: float) -> float:
        """Return λ at a distance [m].

        Raises:
            Wrong: an exception, or no number from 0 to 1.
        """
        function = self._activation
        assert function is not None
        try:
            result = function(distance)
        except BaseException as error:
            raise self._explained(error, _line_of(function)) from None
        try:
            lam = float(result)
        except Exception:
            what = "None" if result is None else f"a {type(result).__name__}"
            raise Wrong(f"activation returned {what}; expected a number from 0 to 1.", _line_of(function)) from None
        if not 0.0 <= lam <= 1.0:
            raise Wrong(f"activation returned {lam:g} at d = {distance:g} m; expected 0 to 1.", _line_of(function))
        return lam

    def rates(self, distances: Array, pull: float, approach: float, square: float) -> Array:
        """Return J_d q̇ (k,) [m/s] of one pair at distances (k,), see `Law.line_rate`; nan where the law fails, or time is up."""
        found = np.full(len(distances), np.nan)
        end = perf_counter() + CURVE
        for i, distance in enumerate(distances.tolist()):
            situation = one_joint(distance, pull, approach, square)
            row = situation.row.copy()
            try:
                found[i] = float(row.dot(self.velocities(situation)[0]))
            except Wrong:
                continue
            if perf_counter() > end:
                break
        return found

    def _explained(self, error: BaseException, otherwise: int | None) -> Wrong:
        """Return what an exception in the file says, and on which of its lines; `otherwise` if on none."""
        self._ballast = None
        line = otherwise
        for frame, number in traceback.walk_tb(error.__traceback__):
            if frame.f_code.co_filename == FILENAME:
                line = number
        if isinstance(error, MemoryError):
            what = f"it wants more memory than the {self._memory >> 20} MiB that a law may take"
        elif isinstance(error, SystemExit):
            what = f"it called exit ({error.code}); a law returns velocities, or raises an exception"
        else:
            what = "".join(traceback.format_exception_only(error)).strip().splitlines()[-1]
        return Wrong(f"{what}{quoted(self._text, line)}", line)


def quoted(text: bytes, line: int | None) -> str:
    """Return “, in …” with a line of a file, counted from 1; "" if there is none."""
    try:
        lines = decode_source(text).splitlines()
    except (SyntaxError, UnicodeDecodeError):
        return ""
    return f", in “{lines[line - 1].strip()}”" if line is not None and 0 < line <= len(lines) else ""


def _syntax(error: SyntaxError) -> tuple[str, int | None]:
    text = f", in “{error.text.strip()}”" if error.text and error.text.strip() else ""
    return f"{type(error).__name__}: {error.msg}{text}", error.lineno


def _line_of(function: object) -> int | None:
    """Return where a function of the file begins; None if it is not of the file."""
    code: CodeType | None = getattr(inspect.unwrap(function) if callable(function) else None, "__code__", None)
    return code.co_firstlineno if code is not None and code.co_filename == FILENAME else None
