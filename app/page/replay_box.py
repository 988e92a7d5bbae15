"""The box beside the scrubber: the replay rests as soon as somebody is about to type a moment there.

A replay that plays writes its moment into the box ten times a second, and would write over what is being typed. Only the browser
knows where the focus is, and a value that is not possible yet (the 1 of 12.5) never reaches the server; so the page's script tells
it by a key.
"""

import html

from app.page.panels.hotkeys import pressing
from app.web.viser_internals import HotkeyKey, KeyModifier

KEY: HotkeyKey = "9"
MODIFIER: KeyModifier = "alt+shift"
"""What the script presses."""


def box_mark(slider: str) -> str:
    """Return HTML by which the script finds the box. `slider`: viser's name for the scrubber that it stands beside."""
    return f'<i hidden data-duet-moment="{html.escape(slider)}"></i>'


def box_script() -> str:
    """Return JavaScript that presses the key when the box gets the focus, and at everything that is typed there."""
    return (
        "(()=>{const rest=e=>{const box=e.target,mark=document.querySelector('[data-duet-moment]');"
        "if(!mark||!(box instanceof HTMLInputElement))return;"
        "const track=document.getElementById(mark.dataset.duetMoment);"
        "if(track&&!track.contains(box)&&track.parentElement.contains(box))" + pressing(repr(KEY)) + "};"
        "for(const kind of ['focusin','beforeinput'])addEventListener(kind,rest,true);})();"
    )
