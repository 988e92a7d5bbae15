"""The notice that a teacher's key is wrong; the script `teacher_key.js` keeps the key in the tab and out of sight."""

from typing import Final

import viser

from app.i18n.speaking import N_, tr

WRONG_KEY: Final = N_(
    "This is not the teacher's key, so you are here as a student. The person who started Duet has the right link."
)
WRONG_TITLE: Final = N_("Wrong teacher key")


def name_mistake(client: viser.ClientHandle) -> None:
    """Show on a page that its key is wrong, and have its tab forget it."""
    client.gui.add_html('<i class="duet-key-wrong"></i>', order=1000.0)
    client.add_notification(tr(WRONG_TITLE), tr(WRONG_KEY), color="orange", auto_close_seconds=12.0)
