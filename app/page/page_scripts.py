"""Scripts and style sheets of the page, in their order, and the constants that they are given."""

from pathlib import Path

from app.i18n.client_texts import ICON_NAMES, LOADING, NO_PICTURE, WHAT_TO_SWITCH_ON, WHAT_WORKS
from app.page import STATIC
from app.page.panels.hotkeys import HOTKEYS
from app.page.panels.replay_bar import KEY
from app.settings import PageSettings
from app.stage.contact_skin import contact_assets
from app.web.index_page import MARK
from app.web.page_assets import PageAssets, software_rendering


def page_assets(page: PageSettings) -> PageAssets:
    """Return what every page runs before viser's client.

    Args:
        page: theme and language, where the link asks for none.
    """
    scripts = (
        "teacher_key without_webgl fast_picture grab_events hand_hover picture_size hotkeys resume announcements "
        "accessible_names replay_box drawing page_language folder_headings class_overlay presenter copy_button link_box pressed_buttons "
        "welcome label_placement contact_chart contact_balance contact_guess contact_card live_equations lit_symbols loading"
    )
    styles = "without_webgl announcements class presenter welcome loading contact_card"
    constants = {
        "withoutWebgl": (NO_PICTURE, WHAT_WORKS, WHAT_TO_SWITCH_ON),
        "relayedKeys": {hotkey.relayed: hotkey.key for hotkey in HOTKEYS if hotkey.relayed},
        "replayKey": KEY,
        "iconNames": ICON_NAMES,
        "loading": {"theme": page.theme, "language": page.language, "text": LOADING},
    }
    return software_rendering() + contact_assets() + PageAssets(_files(scripts, "js"), _files(styles, "css"), constants)


def _files(names: str, kind: str) -> tuple[Path, ...]:
    return tuple(STATIC / f"{name}.{kind}" for name in names.split())


def loading_html() -> str:
    """Return what the page's body begins with: our name, and one line until viser's client is there."""
    return (STATIC / "loading.html").read_text(encoding="utf-8").replace("__MARK__", MARK)
