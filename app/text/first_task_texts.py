"""The words of first tasks other than the distance of the arms, and settings and symbols in the unit of a first task."""

import re
from dataclasses import replace
from typing import Final, NamedTuple, TypeVar

from markupsafe import Markup

from app.i18n.speaking import N_, tr
from scenes.quantities import ALL, DISTANCE, SINGULAR, STOPS, TIP, WALL, KeptQuantity
from scenes.setting_spec import Spec


class FirstTaskTexts(NamedTuple):
    """What is said of a first task, in English.

    Attributes:
        apart: what a value above 0 is, after its unit.
        beyond: what the amount of a value below 0 is, after its unit.
        other: what the arm keeps away from, in one or two words.
        failed: what has happened at a value below 0.
        meaning: sentence on the value, after its symbol.
        kept: sentence on the threshold, after its symbol.
    """

    apart: str
    beyond: str
    other: str
    failed: str
    meaning: str
    kept: str


FIRST_TASK_TEXTS: Final[dict[str, FirstTaskTexts]] = {
    WALL: FirstTaskTexts(
        N_("to the wall"),
        N_("inside the wall"),
        N_("wall"),
        N_("the arm is in the wall"),
        N_("distance of elbow, wrist and hand from the wall."),
        N_("the distance to keep. It is the violet plane in front of the wall."),
    ),
    STOPS: FirstTaskTexts(
        N_("to the joint stops"),
        N_("beyond a joint stop"),
        N_("joint stop"),
        N_("a joint has reached its stop"),
        N_("the angle left to the nearest joint stop."),
        N_("the angle to keep from every joint stop."),
    ),
    SINGULAR: FirstTaskTexts(
        N_("from singular"),
        N_("from singular"),
        N_("singularity"),
        N_("the arm is singular"),
        N_(
            "smallest singular value of J: the hand's speed for joint speeds of 1 rad/s, in the worst direction."
        ),
        N_("the singular value to keep."),
    ),
    TIP: FirstTaskTexts(
        N_("inside the foot"),
        N_("outside the foot"),
        N_("edge of the foot"),
        N_("the cart tips over"),
        N_("distance of the centre of mass from the nearest edge of the foot, seen from above."),
        N_("the distance to keep inside the foot."),
    ),
    ALL: FirstTaskTexts(
        N_("least margin"),
        N_("below the least margin"),
        N_("nearest limit"),
        N_("a first task has failed"),
        N_("the least of all margins, each in its own unit."),
        N_("the same number for each margin, in its own unit."),
    ),
}
"""Name of a first task → its words."""


def in_unit(spec: Spec, quantity: KeptQuantity) -> Spec:
    """Return a setting as it is shown while a first task is chosen: d_m, d_0 and v in its unit, with its symbol."""
    if quantity is DISTANCE:
        return spec
    if spec.key in ("dm", "d0"):
        label = spec.label.replace("d_", f"{quantity.symbol}_")
        words = spec.words if quantity.against or spec.key == "d0" else N_("critical value")
        said = wording(spec.help, quantity)
        return replace(spec, label=label, words=words, help=said, page_unit=quantity.page_unit)
    if spec.key == "v":
        return replace(spec, help=wording(spec.help, quantity), page_unit=quantity.rate_unit)
    return spec


OF_A_VALUE: Final[dict[str, str]] = {
    N_("no joint moves this point"): N_("no joint changes this value"),
    N_("the joints hardly move this point"): N_("the joints hardly change this value"),
    N_("the joints move this point too little"): N_("the joints change this value too little"),
    N_("joints move this point: s = {s}"): N_("joints change this value: s = {s}"),
    N_("between two pairs"): N_("between two first tasks"),
    N_("pressed against its surroundings"): N_("a later stage comes first"),
    N_("other pairs count, too"): N_("other first tasks count, too"),
    N_("the closest pair"): N_("the least of the first tasks"),
    N_("the law distance is below d<sub>m</sub>, but falling no further"): N_(
        "the law’s value is below d<sub>m</sub>, but falling no further"
    ),
    N_("nothing keeps them apart"): N_("nothing keeps the first task"),
    N_("avoidance is off"): N_("the first task is off"),
    N_("the task has no say, and the gap closes"): N_("the task has no say, and d falls"),
    N_("the task has no say, and the gap holds"): N_("the task has no say, and d holds"),
    N_("closes"): N_("falls"),
    N_("opens"): N_("rises"),
    N_("speeds along the line"): N_("rates of the first task"),
    N_("u: how fast the task alone would close the gap."): N_("u: how fast the task alone would lower d."),
    N_("w: how fast {other} comes nearer."): N_(
        "w: how fast d falls by what is not the arm; 0 if nothing else moves."
    ),
    N_("d*: at this distance {arm} comes to rest, because retreat and task are in balance."): N_(
        "d*: at this value {arm} comes to rest, because retreat and task are in balance."
    ),
    N_("d_law: the distance that the law sees. It also counts other pairs that are near."): N_(
        "d_law: the value that the law sees. It also counts the other first tasks."
    ),
    N_("Critical distance: below it avoidance has full priority."): N_(
        "Critical value: below it the first task has full priority."
    ),
    N_("Speed of retreat at full priority; a hand faster than this gets closer than d_m."): N_(
        "Speed of retreat at full priority: how fast the value rises."
    ),
}
"""Text about a distance → the same about a value that is no distance from anything; both are written for d."""


def wording(text: str, quantity: KeptQuantity) -> str:
    """Text, in English, for a distance or for a value; translate it, and then say it `in_symbols`."""
    return text if quantity.against else OF_A_VALUE.get(text, text)


def least_name(quantity: KeptQuantity) -> str:
    """Name of the moment of the smallest value, in English."""
    return N_("smallest distance") if quantity.against else N_("smallest value")


def over_name(quantity: KeptQuantity) -> str:
    """Name of the axis of a first task, in the current language."""
    return tr("distance d") if quantity is DISTANCE else f"{tr(quantity.short)} {quantity.symbol}"


_WRITTEN: Final = re.compile(
    r"<[a-z/][^>]*>"
    r"|(?P<row>J(?:<sub>|_|\$_)d\b)|(?P<rate>ḋ)|(?P<d>\bd(?=\b|[_ₘ]))|(?P<mm>\bmm\b)|(?P<speed>(?<![\w/])m/s\b)|\[m\]"
)
"""Tags, which are left as they are, and what is said otherwise of another first task than a distance."""

Text = TypeVar("Text", str, Markup)


def in_symbols(text: Text, quantity: KeptQuantity) -> Text:
    """A text or HTML about the paper's d, with symbol, row and units of a first task; it names no other length."""
    if quantity is DISTANCE:
        return text

    def said(found: re.Match[str]) -> str:
        match found.lastgroup:
            case "row":
                return f"{found[0][:-1]}a"
            case "rate":
                return f"{quantity.symbol}\N{COMBINING DOT ABOVE}"
            case "d":
                return quantity.symbol
            case "mm":
                return quantity.page_unit
            case "speed":
                return quantity.rate_unit
            case _:
                return f"[{quantity.unit}]" if found[0] == "[m]" else found[0]

    return type(text)(_WRITTEN.sub(said, str(text)))
