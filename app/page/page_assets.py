"""How a page looks: scripts and style sheets in their order, with what depends on the settings (constants, palette and profile), our title
bar, and the theme of viser's widgets below it."""

import base64
from functools import cache
from pathlib import Path
from typing import Final

import viser
from markupsafe import Markup
from viser.theme import TitlebarConfig, TitlebarImage

from app.i18n.client_texts import ICON_NAMES, LOADING, NO_PICTURE, PART_NAMES, WHAT_TO_SWITCH_ON, WHAT_WORKS
from app.i18n.speaking import tr
from app.page import STATIC
from app.page.panels.hotkeys import hotkeys
from app.page.panels.replay_bar import KEY
from app.settings import PageSettings, Profile, Theme
from app.stage.contact_view import contact_assets
from app.text.templates import page_of_template
from app.theme import BRAND, DOCK_WIDTH, NARROW, PALETTES, scale, symbol_rules
from app.web.pages import MARK, PageAssets, software_rendering
from scenes.laws import LAWS


def page_assets(page: PageSettings, lecture: bool = False) -> PageAssets:
    """Return what every page runs before viser's client.

    Args:
        page: theme and language, where the link asks for none.
        lecture: whether all see one stage.
    """
    scripts = (
        "holders teacher_key without_webgl fast_picture grab_events hand_hover picture_size embed hotkeys resume announcements "
        "accessible_names replay_box plot_moments drawing page_language decimal_signs folder_headings class_overlay presenter copy_button "
        "link_box pressed_buttons welcome label_placement contact_chart contact_balance contact_guess contact_lever lambda_tone "
        "contact_card live_equations lit_symbols small_panel law_editor loading"
    )
    styles = "without_webgl announcements class presenter embed welcome loading contact_card law_editor"
    constants = {
        "withoutWebgl": (NO_PICTURE, WHAT_WORKS, WHAT_TO_SWITCH_ON),
        "relayedKeys": {hotkey.relayed: hotkey.key for hotkey in hotkeys() if hotkey.relayed},
        "replayKey": KEY,
        "lecture": lecture,
        "iconNames": ICON_NAMES,
        "partNames": PART_NAMES,
        "loading": {"theme": page.theme, "language": page.language, "text": LOADING},
    }
    return software_rendering() + contact_assets() + PageAssets(_files(scripts, "js"), _files(styles, "css"), constants)


def _files(names: str, kind: str) -> tuple[Path, ...]:
    return tuple(STATIC / f"{name}.{kind}" for name in names.split())


def loading_html() -> str:
    """Return what the page's body begins with: our name, and one line until viser's client is there."""
    return (STATIC / "loading.html").read_text(encoding="utf-8").replace("__MARK__", MARK)


@cache
def style_sheet(profile: Profile) -> Markup:
    """Return the style sheet as a <style> element."""
    k = scale(profile)
    light, dark = PALETTES["light"], PALETTES["dark"]
    colours = symbol_rules(".duet", ".duet-caption") + "".join(
        f".duet .j{i + 1},.duet-caption .j{i + 1}{{color:light-dark({a},{b})}}"
        for i, (a, b) in enumerate(zip(light.joints, dark.joints, strict=True))
    )
    colours += "".join(
        f".duet .law{i + 1}{{color:light-dark({light.laws[i % len(light.laws)]},{dark.laws[i % len(dark.laws)]})}}"
        for i in range(len(LAWS))
    )
    # viser's widgets take their size from this one number of the Mantine library.
    root = f":root{{--duet-k:{k:g};--duet-dock:{DOCK_WIDTH * k:g}px;--mantine-scale:{k:g}!important}}"
    panel, spare = "[data-duet-holds~=plots]", "[data-duet-holds~=spare]"
    narrow = (
        f"@media (max-width:{round(NARROW * k)}px){{"
        f"{panel} [data-duet-holds~=charts]{{grid-template-columns:var(--duet-narrow)!important}}"
        f"{panel} .mantine-Flex-root .mantine-Button-root{{padding:0 6px!important}}"
        f"{panel} {spare},{panel} {spare}+div{{display:none}}}}"
    )
    return Markup(f"<style>{root}{(STATIC / 'style.css').read_text(encoding='utf-8')}{colours}{narrow}</style>")


_LIGHT: Final = PALETTES["light"]


def _mark(ink: str, motto: str) -> str:
    svg = page_of_template("page/panels/title_bar.svg", ink=ink, motto=motto, brand=_LIGHT.brand, faint=_LIGHT.faint)
    return "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode()


def configure_theme(gui: viser.GuiApi, theme: Theme) -> None:
    """Give a page our title bar, and viser's widgets the theme and our colour."""
    gui.configure_theme(
        titlebar_content=titlebar(),
        dark_mode=theme == "dark",
        show_logo=False,
        show_share_button=False,
        brand_color=BRAND,
    )


def titlebar() -> TitlebarConfig:
    """Return viser's title bar with our mark for light and dark, in the visitor's language."""
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
