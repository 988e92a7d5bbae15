"""viser looks up the types of an element's properties for every handle, though they are those of its class: a third of the time in which
a page is built. Relies on viser 1.1."""

from functools import cache
from typing import Any, get_type_hints

from viser._assignable_props_api import AssignablePropsBase

_hints_of = cache(get_type_hints)


def look_up_hints_once() -> None:
    """Have viser keep the types of properties by class. May be called twice."""
    # A type checker knows the attribute as a cached property of every handle.
    setattr(AssignablePropsBase, "_prop_hints", property(_hints))  # noqa: B010


def _hints(handle: AssignablePropsBase[Any]) -> dict[str, Any]:
    return _hints_of(type(handle._impl.props))
