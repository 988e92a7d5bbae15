"""The lever beside the contact card, as shown by `contact_lever.js`."""

from app.i18n.speaking import tr
from app.page.view import View
from app.session.frame import Frame
from scenes.laws import LEVER_LAW
from scenes.settings import LawSettings


class CardLever:
    """The lever on a page that shows a session; it cannot be moved there without a box.

    Attributes:
        box: id of the box that receives the lever's position, on an operator's page; "" elsewhere.
    """

    def __init__(self, view: View) -> None:
        self.box = ""
        self._law: LawSettings | None = None
        self._replayed = False
        view.card_attributes.append(self._attributes)

    def show(self, frame: Frame) -> None:
        self._law, self._replayed = frame.settings.run.law, frame.replayed

    def _attributes(self) -> dict[str, object]:
        """Attributes of the lever with its position [%]; {} under another law."""
        law = self._law
        if law is None or law.law != LEVER_LAW:
            return {}
        ends = [tr("retreat"), tr("task")]
        name, value = tr("λ: your lever"), round(100.0 * law.hand_lever)
        return {
            "lever": {"name": name, "value": value, "ends": ends, "box": "" if self._replayed else self.box}
        }
