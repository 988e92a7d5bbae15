"""The box beside the scrubber: the replay pauses as soon as a moment is about to be typed there.

A replay that plays writes its moment into the box ten times a second, and would overwrite what is being typed. Only the browser
knows where the focus is, and a value that is not possible yet (the 1 of 12.5) never reaches the server; so the script `replay_box.js`
presses a key.
"""

import html

from app.web.viser_internals import HotkeyKey, KeyModifier

KEY: HotkeyKey = "9"
MODIFIER: KeyModifier = "alt+shift"
"""What the script presses."""


def box_mark(slider: str) -> str:
    """Return HTML by which the script finds the box. `slider`: viser's name for the scrubber that it stands beside."""
    return f'<i hidden data-duet-moment="{html.escape(slider)}"></i>'
