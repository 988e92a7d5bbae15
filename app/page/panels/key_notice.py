"""Notice of a wrong teacher's key."""

import viser

from app.i18n.speaking import tr
from app.text.templates import element


def name_mistake(client: viser.ClientHandle) -> None:
    """Show the notice; the tab forgets the key."""
    client.gui.add_html(element("i", class_="duet-key-wrong"), order=1000.0)
    text = tr(
        "This is not the teacher's key, so you are here as a student. The person who started Duet has the right link."
    )
    client.add_notification(tr("Wrong teacher key"), text, color="orange", auto_close_seconds=12.0)
