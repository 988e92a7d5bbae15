"""Words for how well an arm's joints move the closest point, one text per level of the lever s."""

from typing import Final

from app.i18n.speaking import tr
from controllers.laws.situation import FIRM_LEVER

NO_LEVER: Final = 0.1
"""s below which hardly anything of a law's demand is achieved."""


def lever_text(lever: float) -> str:
    """Text for a lever s, see `controllers.laws.situation.lever`; "" if it is firm."""
    if lever >= FIRM_LEVER:
        return ""
    return tr("no joint moves this point") if lever < NO_LEVER else tr("the joints hardly move this point")
