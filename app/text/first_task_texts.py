"""Words, symbols and units of first tasks other than the arms' distance."""

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final, NamedTuple, TypeVar

from markupsafe import Markup

from app.i18n.speaking import N_, tr
from scenes.quantities import ALL, DISTANCE, SINGULAR, STOPS, TIP, WALL, KeptQuantity
from scenes.setting_spec import Spec


class FirstTaskTexts(NamedTuple):
    """English words of a first task.

    Attributes:
        apart, beyond: after the amount above or below 0 and its unit.
        other: what the arm keeps away from, in one or two words.
        failed: what has happened below 0.
        meaning, kept: sentences on the value and the threshold, after their symbols.
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


def in_unit(spec: Spec, quantity: KeptQuantity) -> Spec:
    """A setting's words and page unit for a first task. Words name the paper's d, in English; show them by
    `said_of`.
    """
    if quantity is DISTANCE:
        return spec
    texts = {choice: wording(text, quantity) for choice, text in spec.options().items()}
    units = {
        "dm": quantity.page_unit,
        "d0": quantity.page_unit,
        "dnoise": quantity.page_unit,
        "v": quantity.rate_unit,
        "beta": quantity.sharpness_unit,
        "eta": quantity.field_unit,
    }
    words, said = wording(spec.words, quantity), wording(spec.help, quantity)
    unit = units.get(spec.key, spec.page_unit)
    label = wording(spec.label, quantity)
    return replace(spec, label=label, words=words, help=said, page_unit=unit, options=texts.copy)


def said_of(quantity: KeptQuantity, otherwise: Mapping[str, str] | None = None) -> Callable[[str], str]:
    """Function that translates a text about the paper's d and adapts it to a first task. `otherwise`: see
    `wording`.
    """
    return lambda text: in_symbols(tr(wording(text, quantity, otherwise)), quantity)


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
    N_("approach"): N_("from outside"),
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
    N_("critical distance"): N_("critical value"),
    N_("influence distance"): N_("influence value"),
    N_("pairs"): N_("first tasks"),
    N_("Pairs"): N_("Tasks"),
    N_(
        "What the law sees: the closest pair of bodies (the paper), a smooth minimum over all pairs, or one that stays smooth "
        "also where two links are parallel."
    ): N_(
        "What the law sees: the least of the first tasks, or a smooth minimum over all; the last two are the same here."
    ),
    N_("Closest pair (paper)"): N_("The least one"),
    N_("Barrier QP, all pairs"): N_("Barrier QP"),
    N_("Tell the law how fast the obstacle comes: d ≥ d_m then no longer needs w ≤ v."): N_(
        "Tell the law how fast d falls by what is not the arm: d ≥ d_m then no longer needs w ≤ v."
    ),
    N_("How fast the barrier QP lets the distance above d_m be used up."): N_(
        "How fast the barrier QP lets the value above d_m be used up."
    ),
    N_("How fast the set-based task returns to d_m from below; 0 freezes the distance."): N_(
        "How fast the set-based task returns to d_m from below; 0 freezes the value."
    ),
    N_(
        "Points of a λ of your own: distance in metres, a colon, λ from 0 to 1; with commas between them."
    ): N_("Points of a λ of your own: d [m], a colon, λ from 0 to 1; with commas between them."),
    N_(
        "What is kept when joints meet their bounds: the distance rate; the direction of q̇; or the hand's velocity, too, by joints "
        "that still can."
    ): N_(
        "What is kept when joints meet their bounds: the rate of d; the direction of q̇; or the hand's velocity, too, by joints that "
        "still can."
    ),
    N_("Keep the distance rate"): N_("Keep the rate of d"),
    N_("Frames a second in which the distance is measured; in between d and J_d stay. 0 is every step."): N_(
        "Frames a second in which d is measured; in between d and J_d stay. 0 is every step."
    ),
    N_("Standard deviation of the measured distance, in every frame."): N_(
        "Standard deviation of the measured d, in every frame."
    ),
    N_(
        "The line of contact, a skin as thick as d_m around the obstacle, and a purple tint of the arm that gives way."
    ): N_("What is drawn of the first task, and a purple tint of the arm that gives way."),
    N_(
        "A ghost does the same experiment under the same hand, with another law or with the settings of this moment: a translucent arm, "
        "dashed lines in the plots, and a ring on the line of contact."
    ): N_(
        "A ghost does the same experiment under the same hand, with another law or with the settings of this moment: a translucent arm "
        "and dashed lines in the plots."
    ),
    N_("the arm cannot move away: {why}"): N_("the arm cannot raise d: {why}"),
    N_(
        "There is one pair only: the critical point never changes, and the law is smooth in the strict sense."
    ): N_("There is one first task only, and the law is smooth in the strict sense."),
    N_("{changes} {changes:change|changes} among {pairs} {pairs:pair|pairs}."): N_(
        "{changes} {changes:change|changes} among {pairs} {pairs:first task|first tasks}."
    ),
    N_("The law sees the closest pair only: at every change q̇ may jump."): N_(
        "The law sees the least one only: at every change q̇ may jump."
    ),
    N_("has to open at γ(d<sub>m</sub> − d) at least: {rate} m/s"): N_(
        "has to rise at γ(d<sub>m</sub> − d) at least: {rate} m/s"
    ),
    N_("may come nearer at γ(d − d<sub>m</sub>) at most: {rate} m/s"): N_(
        "may fall at γ(d − d<sub>m</sub>) at most: {rate} m/s"
    ),
}
"""Text about a distance → text about another value; both are written for d."""


OF_A_WALL: Final[dict[str, str]] = {
    text: N_("The line of contact, a violet plane at d_m in front of the wall, and a purple tint of the arm.")
    for text in OF_A_VALUE
    if text.startswith("The line of contact")
}


def wording(text: str, quantity: KeptQuantity, otherwise: Mapping[str, str] | None = None) -> str:
    """English text for a quantity; translate it, then use `in_symbols`. `otherwise`: a feature's texts, as
    `OF_A_VALUE`; None for the core's.
    """
    if quantity is DISTANCE:
        return text
    if quantity.against:
        return OF_A_WALL.get(text, text)
    return (OF_A_VALUE if otherwise is None else otherwise).get(text, text)


def least_name(quantity: KeptQuantity) -> str:
    return N_("smallest distance") if quantity.against else N_("smallest value")


def over_name(quantity: KeptQuantity) -> str:
    return tr("distance d") if quantity is DISTANCE else f"{tr(quantity.short)} {quantity.symbol}"


_WRITTEN: Final = re.compile(
    r"<[a-z/][^>]*>"
    r"|(?P<row>J(?:<sub>|_|\$_)d\b)|(?P<rate>ḋ)|(?P<d>\bd(?=\b|[_ₘ]))|(?P<mm>\bmm\b)|(?P<speed>(?<![\w/])m/s\b)|\[m\]"
)

Text = TypeVar("Text", str, Markup)


def in_symbols(text: Text, quantity: KeptQuantity) -> Text:
    """Text or HTML about the paper's d with a first task's symbol, row and units; it must name no other
    length.
    """
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
