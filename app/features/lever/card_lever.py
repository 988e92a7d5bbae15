"""The lever beside the card of the contact: what the script `contact_lever.js` shows of it."""

from app.i18n.speaking import tr
from app.page.view import View
from app.session.frame import Frame
from scenes.laws import LEVER_LAW
from scenes.settings import LawSettings


class CardLever:
    """The lever on a page that shows a session; without a box it cannot be moved there.

    Attributes:
        box: id of the box that takes where the lever stands, on the page of an operator; "" elsewhere.
    """

    def __init__(self, view: View) -> None:
        self.box = ""
        self._law: LawSettings | None = None
        self._replayed = False
        view.card_attributes.append(self._attributes)

    def show(self, frame: Frame) -> None:
        """Note the law of the run that is shown."""
        self._law, self._replayed = frame.settings.run.law, frame.replayed

    def _attributes(self) -> dict[str, object]:
        """What the card shows of the lever, with its place in percent; {} under another law."""
        law = self._law
        if law is None or law.law != LEVER_LAW:
            return {}
        ends = [tr("retreat"), tr("task")]
        name, value = tr("λ: your lever"), round(100.0 * law.hand_lever)
        return {"lever": {"name": name, "value": value, "ends": ends, "box": "" if self._replayed else self.box}}
