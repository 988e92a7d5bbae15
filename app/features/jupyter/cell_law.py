"""A notebook's function as a custom law's file."""

import ast
import inspect
import math
import textwrap
from collections.abc import Callable
from types import FunctionType, ModuleType
from typing import Any

import numpy as np

from controllers.errors import BadSetting


def law_text(function: Callable[..., Any]) -> str:
    """File with the law, and the notebook's modules, numbers and functions that it uses.

    The law keeps its cell's line numbers, for messages, if possible.

    Raises:
        BadSetting: not written with def, or its text is unknown.
    """
    if not isinstance(function, FunctionType) or function.__name__ == "<lambda>":
        raise BadSetting(
            "duet.law needs a function that is written with def: law(situation), which returns joint velocities."
        )
    head: dict[str, str] = {}
    helpers: dict[str, str] = {}
    _collect(function, head, helpers)
    own = helpers.pop(function.__name__)
    # An annotation is not used by the law, and need not exist.
    first = [*(["from __future__ import annotations"] if function.__annotations__ else []), *head.values()]
    lines = ["; ".join(first)] if first else []
    lines += [""] * (function.__code__.co_firstlineno - 1 - len(lines))
    lines += [own, *helpers.values()]
    if function.__name__ != "law":
        lines.append(f"law = {function.__name__}")
    return "\n".join(lines) + "\n"


def _collect(function: FunctionType, head: dict[str, str], helpers: dict[str, str]) -> None:
    try:
        helpers[function.__name__] = textwrap.dedent(inspect.getsource(function))
        ast.parse(helpers[function.__name__])
    except (OSError, SyntaxError):
        raise BadSetting(
            f"The text of {function.__name__} is not known; write it with def in a cell or in a file."
        ) from None
    names = inspect.getclosurevars(function)
    for name, value in {**names.globals, **names.nonlocals}.items():
        if name in head or name in helpers:
            continue
        if isinstance(value, np.generic):
            # Only Python's numbers can be read back, not NumPy's.
            value = value.item()
        if isinstance(value, ModuleType):
            head[name] = f"import {value.__name__} as {name}"
        elif (
            isinstance(value, FunctionType)
            and value.__module__ == function.__module__
            and value.__name__ == name
        ):
            _collect(value, head, helpers)
        elif isinstance(value, np.ndarray):
            head[name] = f"import numpy; from numpy import inf, nan; {name} = numpy.array({value.tolist()!r})"
        elif isinstance(value, float) and not math.isfinite(value):
            head[name] = f"from numpy import inf, nan; {name} = {value!r}"
        elif isinstance(value, int | float | str | tuple | list | dict) and _reads_back(value):
            head[name] = f"{name} = {value!r}"
        elif callable(value) and getattr(value, "__module__", None) not in (
            None,
            "__main__",
            function.__module__,
        ):
            head[name] = f"from {value.__module__} import {value.__name__} as {name}"


def _reads_back(value: object) -> bool:
    try:
        return ast.literal_eval(repr(value)) == value
    except (ValueError, SyntaxError):
        return False
