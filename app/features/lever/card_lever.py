"""The lever beside the contact card, shown by `contact_lever.js`."""

from app.i18n.speaking import tr
from app.page.view import View
from app.session.frame import Frame
from scenes.laws import LEVER_LAW
from scenes.settings import LawSettings


class CardLever:
    """`box`: id of the box for the lever's position; "" if it cannot be moved here."""

    def __init__(self, view: View) -> None:
        self.box = ""
        self._law: LawSettings | None = None
        self._replayed = False
        view.card_attributes.append(self._attributes)

    def show(self, frame: Frame) -> None:
        self._law, self._replayed = frame.settings.run.law, frame.replayed

    def _attributes(self) -> dict[str, object]:
        """Labels and position [%]; {} under another law."""
        law = self._law
        if law is None or law.law != LEVER_LAW:
            return {}
        ends = [tr("retreat"), tr("task")]
        name, value = tr("λ: your lever"), round(100.0 * law.hand_lever)
        return {
            "lever": {"name": name, "value": value, "ends": ends, "box": "" if self._replayed else self.box}
        }
