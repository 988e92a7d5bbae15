"""Words for each level of the lever s."""

from typing import Final

from app.i18n.speaking import N_, tr
from app.text.first_task_texts import wording
from controllers.laws.situation import FIRM_LEVER
from scenes.quantities import DISTANCE, KeptQuantity

NO_LEVER: Final = 0.1
"""Below this s hardly anything of a law's demand is achieved."""


def lever_text(lever: float, quantity: KeptQuantity = DISTANCE) -> str:
    """Text for a lever s, see `controllers.laws.situation.lever`; "" if it is firm."""
    if lever >= FIRM_LEVER:
        return ""
    text = N_("no joint moves this point") if lever < NO_LEVER else N_("the joints hardly move this point")
    return tr(wording(text, quantity))
