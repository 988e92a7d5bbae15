"""Scripts, styles, title bar and theme of a page."""

import base64
from functools import cache
from itertools import cycle, islice
from pathlib import Path
from typing import Final

import viser
from markupsafe import Markup
from viser.theme import TitlebarConfig, TitlebarImage

from app.i18n.client_texts import (
    ICON_NAMES,
    LOADING,
    NO_PICTURE,
    PART_NAMES,
    PICTURE_LOST,
    WHAT_TO_SWITCH_ON,
    WHAT_WORKS,
)
from app.i18n.speaking import tr
from app.page import STATIC
from app.page.panels.hotkeys import hotkeys
from app.page.panels.replay_bar import KEY
from app.settings import PageSettings, Profile, Theme
from app.stage.contact_view import contact_assets
from app.text.templates import macros, page_of_template
from app.theme import BRAND, DOCK_WIDTH, NARROW, PALETTES, PLOT_HEADROOM, scale, symbol_rules
from app.web.pages import MARK, PageAssets, software_rendering
from scenes.laws import LAWS


def page_assets(page: PageSettings, shared: bool = False) -> PageAssets:
    """Scripts that run before viser's client.

    `page`: theme and language, unless the link asks for others; `shared`: True if all tabs see one
    session.
    """
    scripts = (
        "holders teacher_key without_webgl lost_picture fast_picture grab_events hand_hover picture_size embed hotkeys resume "
        "announcements accessible_names replay_box plot_moments drawing page_language decimal_signs folder_headings page_overlay "
        "copy_button link_box pressed_buttons tooltip_placement label_placement contact_chart contact_balance contact_guess lambda_tone "
        "label_distance contact_card live_equations lit_symbols symbol_sentences small_panel tab_row "
        "loading"
    )
    styles = "without_webgl lost_picture announcements notes page_overlay embed loading contact_card"
    constants = {
        "withoutWebgl": (NO_PICTURE, WHAT_WORKS, WHAT_TO_SWITCH_ON),
        "pictureLost": PICTURE_LOST,
        "relayedKeys": {hotkey.relayed: hotkey.key for hotkey in hotkeys() if hotkey.relayed},
        "replayKey": KEY,
        "shared": shared,
        "iconNames": ICON_NAMES,
        "partNames": PART_NAMES,
        "loading": {"theme": page.theme, "language": page.language, "text": LOADING},
    }
    return (
        software_rendering()
        + contact_assets()
        + PageAssets(_files(scripts, "js"), _files(styles, "css"), constants)
    )


def _files(names: str, kind: str) -> tuple[Path, ...]:
    return tuple(STATIC / f"{name}.{kind}" for name in names.split())


def loading_html() -> str:
    """Start of the page's body, shown until viser's client has loaded."""
    return (STATIC / "loading.html").read_text(encoding="utf-8").replace("__MARK__", MARK)


@cache
def style_sheet(profile: Profile) -> Markup:
    k, light, dark = scale(profile), PALETTES["light"], PALETTES["dark"]
    laws = zip(cycle(light.laws), cycle(dark.laws), strict=False)
    return macros("page/panels/style.html").sheet(
        f"{k:g}",
        f"{DOCK_WIDTH * k:g}",
        round(NARROW * k),
        f"{PLOT_HEADROOM * k:g}",
        Markup((STATIC / "style.css").read_text(encoding="utf-8") + symbol_rules(".duet", ".duet-caption")),
        list(zip(light.joints, dark.joints, strict=True)),
        list(islice(laws, len(LAWS))),
    )


_LIGHT: Final = PALETTES["light"]


def _mark(ink: str, motto: str) -> str:
    svg = page_of_template(
        "page/panels/title_bar.svg", ink=ink, motto=motto, brand=_LIGHT.brand, faint=_LIGHT.faint
    )
    return "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode()


def configure_theme(gui: viser.GuiApi, theme: Theme) -> None:
    gui.configure_theme(
        titlebar_content=titlebar(),
        dark_mode=theme == "dark",
        show_logo=False,
        show_share_button=False,
        brand_color=BRAND,
    )


def titlebar() -> TitlebarConfig:
    motto = tr("two arms, one gives way")
    return TitlebarConfig(
        buttons=None,
        image=TitlebarImage(
            image_url_light=_mark(_LIGHT.ink, motto),
            image_url_dark=_mark(PALETTES["dark"].ink, motto),
            image_alt=f"Duet: {motto}",
            href=None,
        ),
    )
