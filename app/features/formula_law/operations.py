"""Names, signs and functions of a formula."""

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np

NAMES: Final = ("d", "u", "w", "v", "d_m", "n")
"""Distance [m], task's pull [m/s], obstacle's approach [m/s], speed of retreat [m/s], d_m [m], order."""

FUNCTIONS: Final = {
    "min": (2, 8),
    "max": (2, 8),
    "clip": (3, 3),
    **dict.fromkeys(("abs", "exp", "log", "sqrt", "tanh"), (1, 1)),
}
"""Least and largest number of arguments; `where` is separate."""

COMPARISONS: Final = ("<", "<=", ">", ">=")

Evaluated = Callable[[Sequence[Any]], Any]


class Operations(NamedTuple):
    """Implementation of each sign and function. `where`: (comparison, then, else) → the conditional part."""

    signs: Mapping[str, Callable[..., Any]]
    negative: Callable[[Any], Any]
    functions: Mapping[str, Callable[..., Any]]
    where: Callable[[Evaluated, Evaluated, Evaluated], Evaluated]

    def of(self, what: str, count: int) -> Callable[..., Any]:
        """Implementation of a function, or of a sign with `count` operands."""
        if what in self.functions:
            return self.functions[what]
        return self.negative if count == 1 else self.signs[what]


_SIGNS: Final = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


def _chosen(condition: Evaluated, then: Evaluated, otherwise: Evaluated) -> Evaluated:
    # The other branch may be undefined there.
    return lambda values: then(values) if condition(values) else otherwise(values)


SCALARS: Final = Operations(
    _SIGNS | {"^": math.pow},
    operator.neg,
    {
        "min": min,
        "max": max,
        "clip": lambda value, least, most: min(max(value, least), most),
        "abs": abs,
        "exp": math.exp,
        "log": math.log,
        "sqrt": math.sqrt,
        "tanh": math.tanh,
    },
    _chosen,
)
"""For floats; ArithmeticError or ValueError where a value is not defined."""


def _least(*values: Any) -> Any:
    least = values[0]
    for value in values[1:]:
        least = np.minimum(least, value)
    return least


def _largest(*values: Any) -> Any:
    return -_least(*(np.negative(value) for value in values))


def _each_chosen(condition: Evaluated, then: Evaluated, otherwise: Evaluated) -> Evaluated:
    return lambda values: np.where(condition(values), then(values), otherwise(values))


ARRAYS: Final = Operations(
    # Two floats behave like elements of an array: no exception in a division or a power.
    _SIGNS | {"/": np.divide, "^": np.float_power},
    np.negative,
    {
        "min": _least,
        "max": _largest,
        "clip": lambda value, least, most: _least(_largest(value, least), most),
        "abs": np.abs,
        "exp": np.exp,
        "log": np.log,
        "sqrt": np.sqrt,
        "tanh": np.tanh,
    },
    _each_chosen,
)
"""For arrays; nan or inf where a value is not defined."""
