"""The words for how well an arm's joints move the closest point: one for each level of the lever s, wherever it is told."""

from typing import Final

from app.i18n.speaking import tr
from controllers.laws.situation import FIRM_LEVER

NO_LEVER: Final = 0.1
"""s below which hardly anything is left of what a law asks for."""


def lever_text(lever: float) -> str:
    """Return the words for a lever s, see `controllers.laws.situation.lever`; "" if it is firm."""
    if lever >= FIRM_LEVER:
        return ""
    return tr("no joint moves this point") if lever < NO_LEVER else tr("the joints hardly move this point")
