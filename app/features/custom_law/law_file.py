"""A law's file in its own process; messages name its lines."""

import contextlib
import inspect
import os
import traceback
from collections.abc import Callable
from importlib.util import decode_source
from time import perf_counter
from types import CodeType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.features.custom_law.law_limits import without_core
from controllers.errors import LazyText, joined
from controllers.laws.situation import Situation

Array = NDArray[np.float64]
"""As in `controllers.kinematics`, without its libraries."""

JOINTS = 7
"""Joints in `one_joint`: laws like to build 7 × 7 matrices."""

LOOSE = 100.0
"""Unreachable bounds in `one_joint` [rad/s]."""


def one_joint(distance: float, pull: float, approach: float, square: float) -> Situation:
    """Situation in which only the first joint moves the distance, with |J_d|² = `square`, 1 if that is 0."""
    length = square**0.5 if square > 0.0 else 1.0
    nominal, row = np.zeros(JOINTS), np.zeros(JOINTS)
    nominal[0], row[0] = -pull / length, length
    bound = np.full(JOINTS, LOOSE)
    near = np.array([distance]), np.array([approach])
    return Situation(
        np.zeros(JOINTS), nominal, row, distance, approach, None, -bound, bound, row[None, :].copy(), *near
    )


FILENAME: Final = "<own law>"
"""In tracebacks: plain letters, which every tool can print."""

LONGEST: Final = 300
"""Longest message [characters]."""

CURVE: Final = 0.02
"""Time for a chart's curve [s]; the rest is left out."""

BALLAST: Final = 4 * 2**20
"""Memory to report that memory is exhausted [bytes]."""


class Wrong(Exception):
    """A fault of the file. `text`: fault and expectation; with parts, a `LazyText` template."""

    def __init__(self, text: str, /, line: int | None = None, **parts: object) -> None:
        made = LazyText(text, **parts) if parts else text
        super().__init__(made)
        self.text = made if len(made) <= LONGEST else made[: LONGEST - 1] + "…"
        self.line = line


class LawFile:
    """The functions of a file.

    Args:
        text: raw content, in its declared encoding.
        memory: limit, for messages [bytes].

    Attributes:
        wants_all_pairs: true if it reads `rows`, `distances` and `approaches`.

    Raises:
        Wrong: it does not compile, fails, or has no function `law` of one argument.
    """

    def __init__(self, path: str, text: bytes, memory: int) -> None:
        self._memory, self._text = memory, text
        self._ballast: bytearray | None = bytearray(BALLAST)
        if not _is_text(text):
            raise Wrong("it cannot be read as text; save it as Python text in UTF-8")
        try:
            code = compile(text, FILENAME, "exec", dont_inherit=True)
        except SyntaxError as error:
            what = f"{type(error).__name__}: {error.msg}"
            raise Wrong(joined((what, quoted(text, error.lineno)), ""), error.lineno) from None
        except (RecursionError, MemoryError):
            self._ballast = None
            raise Wrong("its text is nested too deeply, or too long, for Python") from None
        # Not "__main__": code under `if __name__ == "__main__"` is for trials by hand.
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
        function = names.get(name)
        if function is None:
            return None
        if not callable(function):
            raise Wrong(
                "{name} is a {kind}; it must be a function: def {name}({argument}).",
                name=name,
                kind=type(function).__name__,
                argument=argument,
            )
        try:
            inspect.signature(function).bind(None)
        except TypeError as error:
            raise Wrong(
                "{name} must take one argument, {name}({argument}): {error}.",
                line=_line_of(function),
                name=name,
                argument=argument,
                error=str(error),
            ) from None
        except ValueError:
            pass  # Written in C: the call will show it.
        return function

    def velocities(self, situation: Situation) -> tuple[Array, float]:
        """q̇ (n,) [rad/s] and its computing time [s].

        Raises:
            Wrong: an exception, or not n finite numbers.
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
        line = _line_of(self._law)
        parts = {
            "line": line,
            "expected": LazyText("{n} joint velocities [rad/s], an array of shape ({n},)", n=n),
        }
        if result is None:
            raise Wrong("law returned None; expected {expected}. Is a `return` missing?", **parts)
        try:
            array = np.asarray(result)
            number = array.dtype.kind in "fiub"
        except ValueError:
            raise Wrong(
                "law returned a {kind} of uneven parts; expected {expected}.",
                kind=type(result).__name__,
                **parts,
            ) from None
        if not number:
            if array.dtype.kind == "c":
                raise Wrong("law returned complex numbers; expected {expected}.", **parts)
            kind = type(result).__name__
            raise Wrong(
                "law returned a {kind} that holds no plain numbers; expected {expected}.", kind=kind, **parts
            )
        if array.shape != (n,):
            if array.shape == ():
                raise Wrong("law returned a single number; expected {expected}.", **parts)
            raise Wrong(
                "law returned an array of shape {shape}; expected {expected}.",
                shape=str(array.shape),
                **parts,
            )
        velocities = array.astype(np.float64, copy=False)
        finite = np.isfinite(velocities)
        if np.count_nonzero(finite) < n:
            joint = int(np.argmin(finite))
            raise Wrong(
                "law returned {value} for joint {joint} of {n}; expected finite numbers.",
                line=line,
                value=str(velocities[joint]),
                joint=joint + 1,
                n=n,
            )
        return velocities

    def activation(self, distance: float) -> float:
        """λ at a distance [m].

        Raises:
            Wrong: an exception, or not in [0, 1].
        """
        function, line = self._activation, _line_of(self._activation)
        assert function is not None
        try:
            result = function(distance)
        except BaseException as error:
            raise self._explained(error, line) from None
        try:
            lam = float(result)
        except Exception:
            if result is None:
                raise Wrong("activation returned None; expected a number from 0 to 1.", line) from None
            kind = type(result).__name__
            raise Wrong(
                "activation returned a {kind}; expected a number from 0 to 1.", line, kind=kind
            ) from None
        if not 0.0 <= lam <= 1.0:
            at = f"{distance:g}"
            raise Wrong(
                "activation returned {lam} at d = {distance} m; expected 0 to 1.",
                line,
                lam=f"{lam:g}",
                distance=at,
            )
        return lam

    def activations(self, distances: Array) -> Array:
        """λ (k,) at distances (k,) [m], see `_curve`."""
        return _curve(self.activation, distances)

    def rates(self, distances: Array, pull: float, approach: float, square: float) -> Array:
        """J_d q̇ (k,) [m/s] of one pair, see `Law.line_rate` and `_curve`."""

        def rate(distance: float) -> float:
            situation = one_joint(distance, pull, approach, square)
            row = situation.row.copy()
            return float(row.dot(self.velocities(situation)[0]))

        return _curve(rate, distances)

    def _explained(self, error: BaseException, otherwise: int | None) -> Wrong:
        self._ballast = None
        line = otherwise
        for frame, number in traceback.walk_tb(error.__traceback__):
            if frame.f_code.co_filename == FILENAME:
                line = number
        if isinstance(error, MemoryError):
            what: str = LazyText(
                "it wants more memory than the {size} MiB that a law may take", size=self._memory >> 20
            )
        elif isinstance(error, SystemExit):
            what = LazyText(
                "it called exit ({code}); a law returns velocities, or raises an exception",
                code=str(error.code),
            )
        else:
            what = "".join(traceback.format_exception_only(error)).strip().splitlines()[-1]
        return Wrong(joined((what, quoted(self._text, line)), ""), line)


def _curve(function: Callable[[float], float], distances: Array) -> Array:
    """Values (k,) at distances (k,) [m]; nan after a failure or the time limit."""
    found = np.full(len(distances), np.nan)
    end, waited = perf_counter() + CURVE, without_core(os.getpid())
    for i, distance in enumerate(distances.tolist()):
        with contextlib.suppress(Wrong):
            found[i] = function(distance)
        # Asking the system costs more than a point.
        if (now := perf_counter()) > end and now - (without_core(os.getpid()) - waited) > end:
            break
    return found


def _is_text(text: bytes) -> bool:
    """True if valid in the declared encoding (Python's message depends on its version)."""
    try:
        return "\0" not in decode_source(text)
    except (SyntaxError, ValueError, LookupError):
        return False


def quoted(text: bytes, line: int | None) -> str:
    """“, in …” with a line of a file (1-based), or ""."""
    try:
        lines = decode_source(text).splitlines()
    except (SyntaxError, UnicodeDecodeError):
        return ""
    return (
        LazyText(", in “{text}”", text=lines[line - 1].strip())
        if line is not None and 0 < line <= len(lines)
        else ""
    )


def _line_of(function: object) -> int | None:
    code: CodeType | None = getattr(
        inspect.unwrap(function) if callable(function) else None, "__code__", None
    )
    return code.co_firstlineno if code is not None and code.co_filename == FILENAME else None
