"""Two things of viser 1.1 that take most of the time in which a page is built: it looks up the types of an element's properties for every
handle, though they are those of its class; and it reads the directory of all its icons for every icon, of which it keeps but 32."""

from functools import cache
from typing import Any, Final, get_type_hints
from zipfile import ZipFile

from viser import _gui_api, _gui_handles
from viser._assignable_props_api import AssignablePropsBase
from viser._icons import ICONS_DIR

_hints_of: Final = cache(get_type_hints)


def make_handles_cheap() -> None:
    """Have viser look up both once for everybody. May be called twice."""
    # A type checker knows the attribute as a cached property of every handle.
    setattr(AssignablePropsBase, "_prop_hints", property(_hints))  # noqa: B010
    for module in (_gui_api, _gui_handles):
        vars(module)["svg_from_icon"] = _icon


def _hints(handle: AssignablePropsBase[Any]) -> dict[str, Any]:
    return _hints_of(type(handle._impl.props))


@cache
def _icon(name: str) -> str:
    return _icons().read(f"{name}.svg").decode("utf-8")


@cache
def _icons() -> ZipFile:
    return ZipFile(ICONS_DIR / "tabler-icons.zip")
