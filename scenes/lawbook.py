"""Settings → law."""

from controllers.laws.situation import Law
from controllers.laws.smooth_priority import SmoothPriority
from controllers.laws.unprotected import Unprotected
from scenes.settings import LawSettings


def make_law(settings: LawSettings) -> Law:
    """Return the law that the settings describe."""
    if settings.law == "unprotected":
        return Unprotected()
    return SmoothPriority(
        settings.critical_distance, settings.order, settings.nominal_velocity, settings.feed_forward, settings.one_sided
    )
