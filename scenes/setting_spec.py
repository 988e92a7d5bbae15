"""Declarations of settings for the command line, the page, links and exports."""

import difflib
import math
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from itertools import permutations
from typing import Any, Final, TypeVar, get_args

from controllers.errors import BadSetting, LazyText

T = TypeVar("T")


SPEC: Final = "spec"


@dataclass(frozen=True)
class Tab:
    """A part of a tab of the page; `place` orders the parts."""

    name: str
    place: int = 0

    def number(self, default: T, key: str, label: str, text: str, *scale: Any, words: str = "") -> T:
        """Declare a number; `scale`: `unit` … `page_scale` of `Spec`."""
        return field(default=default, metadata={SPEC: Spec(self, key, label, text, *scale, words=words)})

    def flag(self, key: str, label: str, text: str, default: bool = False, words: str = "") -> bool:
        return field(default=default, metadata={SPEC: Spec(self, key, label, text, words=words)})

    def text(
        self, default: str, read: Callable[[str], str], key: str, label: str, text: str, words: str = ""
    ) -> str:
        return field(default=default, metadata={SPEC: Spec(self, key, label, text, words=words, read=read)})

    def choice(self, default: str, kind: Any, key: str, label: str, text: str, *labels: str) -> Any:
        """Declare choices.

        Args:
            kind: their Literal; without `labels` a function as `Spec.options`.

        Raises:
            ValueError: the numbers of labels and choices differ.
        """
        options = dict(zip(get_args(kind), labels, strict=True)).copy if get_args(kind) else kind
        return field(default=default, metadata={SPEC: Spec(self, key, label, text, options=options)})


@dataclass(frozen=True)
class Spec:
    """Declaration of one setting.

    Attributes:
        key: on the command line (`--dm`) and in a link (`?dm=`).
        label: such as "d_m" or "law".
        unit: SI unit; "" for a pure number.
        low, high: range of a number [SI].
        step: of its slider, in page units.
        page_unit, page_scale: page value = scale · SI value.
        words: meaning of a symbol in `label`; "" if the label is a word.
        options: returns value → label of the choices, in order.
        read: returns the normal form of a text, or raises `BadSetting`; None if the value is not a text.
    """

    tab: Tab
    key: str
    label: str
    help: str
    unit: str = ""
    low: float = -math.inf
    high: float = math.inf
    step: float = 0.0
    page_unit: str = ""
    page_scale: float = 1.0
    words: str = ""
    options: Callable[[], Mapping[str, str]] = dict[str, str]
    read: Callable[[str], str] | None = None

    @property
    def is_number(self) -> bool:
        return not self.choices and self.read is None

    @property
    def choices(self) -> tuple[str, ...]:
        return tuple(self.options())

    def title(self, say: Callable[[str], str] = str) -> str:
        """Label such as "critical distance d_m [mm]". `say`: translation."""
        unit = f"[{self.page_unit}]" if self.page_unit else ""
        return " ".join(part for part in (self.words and say(self.words), say(self.label), unit) if part)


def checked(
    spec: Spec, present: object, value: object, remedy_of: Callable[[str], LazyText | None] = lambda _: None
) -> Any:
    """Checked value of a field; the present value gives the type.

    Args:
        remedy_of: remedy for an impossible choice, or None.

    Raises:
        BadSetting: not a value of the field.
    """
    if spec.choices:
        if isinstance(value, str) and value in spec.choices:
            return value
        if isinstance(value, str) and (missing := remedy_of(value)):
            raise BadSetting(missing)
        known = spec.choices
        if len(known) > MOST_LISTED:
            # Arms from files make pairs with all others.
            known = (*(nearest_names(str(value), known) or known[:NEAREST]), "…")
        shown = {"key": spec.key, "value": _shown(value), "known": ", ".join(known)}
        raise BadSetting("{key} = {value} is not possible; choose from {known}.", **shown)
    if spec.read is not None:
        return spec.read(value if isinstance(value, str) else str(value))
    if isinstance(present, bool):
        return _checked_flag(spec, value)
    unit = f" {spec.unit}" if spec.unit else ""
    remedy = LazyText(
        "give a number from {low:g} to {high:g}{unit}.", low=spec.low, high=spec.high, unit=unit
    )
    fields = {"key": spec.key, "value": _shown(value), "remedy": remedy}
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise BadSetting("{key} = {value} is not a number; {remedy}", **fields)
    try:
        number = float(value)
    except (ValueError, OverflowError):
        raise BadSetting("{key} = {value} is not a number; {remedy}", **fields) from None
    # A slider's value comes back through its own page unit: the last bit must not push it over the edge.
    slack = 1e-9 * max(abs(spec.low), abs(spec.high))
    if not math.isfinite(number) or number < spec.low - slack or number > spec.high + slack:
        raise BadSetting("{key} = {value} is out of range; {remedy}", **fields)
    number = min(max(number, spec.low), spec.high)
    if isinstance(present, int):
        if number != int(number):
            raise BadSetting("{key} = {value} is not a whole number; {remedy}", **fields)
        return int(number)
    return number


MOST_LISTED: Final = 20

NEAREST: Final = 3


def nearest_names(name: str, known: Collection[str]) -> tuple[str, ...]:
    """Known names similar to `name`, the nearest first; may be ()."""
    lower = {one.lower(): one for one in known}
    return tuple(lower[found] for found in difflib.get_close_matches(name[:80].lower(), lower, NEAREST, 0.5))


def unknown_setting(key: str, known: Collection[str]) -> BadSetting:
    shown = key if len(key) <= 40 else key[:39] + "…"
    if nearest := nearest_names(key, known):
        return BadSetting(
            "There is no setting {key!r}; did you mean {nearest}? `lwr-duet serve --help-all` lists them all.",
            key=shown,
            nearest=", ".join(nearest),
        )
    return BadSetting("There is no setting {key!r}; `lwr-duet serve --help-all` lists them all.", key=shown)


def _checked_flag(spec: Spec, value: object) -> bool:
    if isinstance(value, bool):
        return value
    words = {
        "1": True,
        "true": True,
        "on": True,
        "yes": True,
        "0": False,
        "false": False,
        "off": False,
        "no": False,
    }
    if isinstance(value, str) and value.lower() in words:
        return words[value.lower()]
    raise BadSetting("{key} = {value} is neither on nor off; give 1 or 0.", key=spec.key, value=_shown(value))


def _shown(value: object) -> str:
    text = repr(value) if isinstance(value, str) else str(value)
    return text if len(text) <= 40 else text[:37] + "…"


PAIR: Final = "_"
"""Separator of two makes, left first."""

FILE_NAME: Final = re.compile(r"([a-z0-9-]{1,24})-([0-9a-f]{12})")
"""Robot from a file: file name and first digits of its content's hash."""

_NUMBERS: Final = r"-?[0-9.]{1,8}(?:,-?[0-9.]{1,8}){3}"
BASES_NAME: Final = re.compile(rf"{_NUMBERS}:{_NUMBERS}")
"""Rig with given bases: x,y,z,yaw of left and right [m, degrees]."""

_ADDED: Final[dict[str, dict[str, str]]] = {}


_OFFERED: Final[dict[str, dict[str, str]]] = {}


def offer_choices(choices: Mapping[str, Mapping[str, str]]) -> None:
    """Add choices (key → value → label) after the declared ones."""
    for key, labels in choices.items():
        _OFFERED.setdefault(key, {}).update(labels)


def add_choice(key: str, value: str, label: str) -> None:
    """Add a choice in this process; only for the command line, never for a visitor."""
    _ADDED.setdefault(key, {})[value] = label


def added_choices() -> dict[str, dict[str, str]]:
    return _ADDED


def makes(robot: str) -> tuple[str, str]:
    left, _, right = robot.partition(PAIR)
    return left, right or left


def with_added(spec: Spec) -> Spec:
    """The spec with all choices of this process, including pairs of makes."""
    added = _OFFERED.get(spec.key, {}) | _ADDED.get(spec.key, {})
    if not added and spec.key != "robot":
        return spec
    known = {**spec.options(), **added}
    if spec.key == "robot":
        known |= {f"{a}{PAIR}{b}": f"{known[a]} | {known[b]}" for a, b in permutations(tuple(known), 2)}
    return replace(spec, options=known.copy)


def start_remedy(value: str) -> LazyText | None:
    """Start options that would make a value possible, or None."""
    for make in makes(value):
        if (found := FILE_NAME.fullmatch(make)) and make not in _ADDED.get("robot", {}):
            return LazyText(
                "The robot {name} is from a URDF file that was not given here: start Duet with --robot and the same file, "
                "{stem}.urdf, unchanged, and with the same --hand-left or --hand-right if its hand was named.",
                name=make,
                stem=found[1],
            )
    if BASES_NAME.fullmatch(value):
        left, right = value.split(":")
        return LazyText(
            "These bases were not given here: start Duet with --base-left={left} --base-right={right}.",
            left=left,
            right=right,
        )
    return None
