"""Texts of the studies for other first tasks, like `OF_A_VALUE`."""

from typing import Final

from app.i18n.speaking import N_

NO_SETTING: Final = N_(
    "{law} has no setting for its distance: it comes as near as {reached} mm, the other law {wanted} mm."
)

NO_VALUE: Final = N_(
    "No value of {knob} helps: the other law comes as near as {wanted} mm, {law} at best {reached} mm. Change another setting first, "
    "such as d_m."
)

AS_NEAR: Final = N_("{law} with {knob} = {value} comes as near as {reached} mm, the ghost’s law {wanted} mm.")

ONE_PAIR: Final = N_("What was missing: one closest pair.")

OF_A_STUDIED_VALUE: Final[dict[str, str]] = {
    NO_SETTING: N_(
        "{law} has no setting for its least d: that is {reached} mm, under the other law {wanted} mm."
    ),
    NO_VALUE: N_(
        "No value of {knob} helps: the least d is {wanted} mm under the other law, at best {reached} mm under {law}. Change another "
        "setting first, such as d_m."
    ),
    AS_NEAR: N_(
        "{law} with {knob} = {value}: the least d is {reached} mm, under the ghost’s law {wanted} mm."
    ),
    ONE_PAIR: N_("What was missing: one first task that is the least."),
    N_("same distance"): N_("same least d"),
    N_(
        "Sets d_m, or another setting of the ghost’s law, so that it comes as near as the present law on the last 30 s; the present "
        "settings become the ghost. With a frozen ghost it sets the run’s law."
    ): N_(
        "Sets d_m, or another setting of the ghost’s law, so that the least d is that of the present law on the last 30 s; the present "
        "settings become the ghost. With a frozen ghost it sets the run’s law."
    ),
}
