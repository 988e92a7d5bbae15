"""Texts that the browser shows without the server: viser's client's and our scripts'. The page's
`translation.js` translates them wherever they appear.
"""

from typing import Final

from app.i18n.catalogue import DECIMAL_SIGN, words_of
from app.i18n.speaking import N_
from app.settings import TRANSLATIONS

LOST: Final = N_("Connection lost – trying again…")
SILENT: Final = N_("The server does not answer – waiting…")
KEPT_OUT: Final = N_("Duet does not know this address. Start it with --allow-origin {name}")
CROWDED: Final = N_("This page is open in too many tabs. Close some of them, then reload this one.")
OPEN_TWICE: Final = N_("Duet is open in another tab of this browser. Click here to continue in this one.")

NO_PICTURE: Final = N_("No picture: WebGL is switched off in this browser")
WHAT_WORKS: Final = N_(
    "Lessons, plots, numbers and controls still work; the arrow keys move the hand, J and K the elbow."
)
WHAT_TO_SWITCH_ON: Final = N_(
    "To see the arms, switch on graphics acceleration in the browser’s settings and start the browser again, or use another browser."
)

PICTURE_LOST: Final = N_(
    "The picture is lost: the graphics card gave it up. Reload this page to see the arms again."
)
"""Shown by `lost_picture.js` until the browser restores the picture."""

LOADING: Final = N_("Loading …")

SOFTWARE: Final = N_("Drawn without a graphics card; it may stutter.")

ICON_NAMES: Final = {
    "search": N_("every command by name"),
    "list": N_("every command by name"),
    "adjustments": N_("connection and camera"),
    "arrow": N_("back to the controls"),
}
"""Part of an icon's name → name of viser's button; see `accessible_names.js`."""

PART_NAMES: Final = {
    "scene": N_("The arms in 3-D. The key I describes what is to be seen."),
    "stage": N_("The arms in 3-D"),
    "left": N_("Lesson"),
    "right": N_("Controls"),
    "floating": N_("Live plots"),
}
"""The picture (`stage`: a shared session's) and the parts around it."""

OURS: Final = (
    LOST,
    LOADING,
    SOFTWARE,
    CROWDED,
    OPEN_TWICE,
    SILENT,
    KEPT_OUT,
    NO_PICTURE,
    WHAT_WORKS,
    WHAT_TO_SWITCH_ON,
    PICTURE_LOST,
    *ICON_NAMES.values(),
    *PART_NAMES.values(),
    DECIMAL_SIGN,
    N_("more"),
    N_("dismiss this message"),
    # The page of a full room.
    N_("Duet – every place is taken"),
    N_("Every place is taken"),
    N_("This Duet has one place, and it is taken."),
    N_("This Duet has {name} places, and all of them are in use."),
    N_("You needn’t do anything: this page lets you in as soon as a place is free."),
    N_("Waiting for a place…"),
    # Keys in viser's list of commands, which writes them as they are in its code.
    "space",
    "pageup",
    "pagedown",
)

VISERS: Final = (
    *("Connected", "Connecting...", "Inactive", "Connection rejected"),
    *("Search commands...", "No matching commands..."),
    *("Open navigation", "Close navigation", "Return to GUI", "Configuration & diagnostics", "Control panel"),
    *(
        "Expand panel",
        "Minimize panel",
        "Expand column",
        "Collapse column",
        "Expand panels",
        "Minimize panels",
    ),
    *("Collapse panel area", "Expand panel {name}", "Collapse panel {name}", "Expand plot", "Expand image"),
    *(
        "Server",
        "Server URL",
        "Save Canvas",
        "Reset View",
        "Orbit Origin Tool",
        "Dev Settings",
        "Scene tree",
        "local",
    ),
    "Show tool for setting the look-at point and",
    "up direction of the camera.",
    "This can be used to set the origin of the",
    "camera's orbit controls.",
    *("Dark Mode", "WebGL Stats", "Show Viser Logo", "Log Camera to Console", "Show Orbit Crosshair"),
    *("Device Pixel Ratio", "Adaptive", "Reset Panel Layout"),
    *("Log camera position and orientation to the", "Javascript console."),
    *("Show crosshair at look-at point", "when moving camera."),
    *("Device pixel ratio for rendering.", "Default (adaptive) behavior dynamically"),
    "reduces resolution to maintain framerates.",
    "Discard any panel rearrangement and restore the layout the server set.",
    *("Edit props for {name}", "Close props", "Local Props", "Invalid JSON"),
    *(
        "Updates from the server will overwrite local changes.",
        "Client-local: only this client sees this node",
    ),
    *(
        "Toggle visibility override",
        "Clear visibility override",
        "Auto-created anchor for client-local children",
    ),
    *("Uploading {name}", "File uploaded successfully.", "Receiving {name}", "Received {name}"),
    "WebGL unavailable",
    "WebGL is unavailable. This may be caused by hardware acceleration being disabled — check your browser settings.",
    *(
        "Could not detect browser version",
        "Your browser version could not be detected. It may not be supported.",
    ),
    "Unsupported browser",
)
"""Shown by viser's client; {name} matches anything."""

ALL: Final = (*OURS, *VISERS)


def translations() -> dict[str, dict[str, str]]:
    """Language → English text → its translation, for `translation.js`."""
    return {name: {english: words_of(name)(english) for english in ALL} for name in (*TRANSLATIONS, "pseudo")}
