"""The style sheet of the controls: the rules of `static/style.css`, and what depends on the palette and the profile."""

from functools import cache

from app.page import STATIC
from app.settings import Profile
from app.theme import DOCK_WIDTH, NARROW, PALETTES, scale


@cache
def style_sheet(profile: Profile) -> str:
    """Return the style sheet as a <style> element."""
    k = scale(profile)
    symbols = {
        "d": "distance",
        "dm": "critical",
        "rest": "resting",
        "lam": "activation",
        "e": "error",
        "v": "velocity",
        "u": "pull",
        "w": "approach",
    }
    light, dark = PALETTES["light"], PALETTES["dark"]
    colours = "".join(
        f".duet .{name},.duet-caption .{name}{{color:light-dark({getattr(light, field)},{getattr(dark, field)})}}"
        for name, field in symbols.items()
    )
    colours += "".join(
        f".duet .j{i + 1},.duet-caption .j{i + 1}{{color:light-dark({a},{b})}}"
        for i, (a, b) in enumerate(zip(light.joints, dark.joints, strict=True))
    )
    colours += "".join(
        f".duet .law{i + 1}{{color:light-dark({a},{b})}}" for i, (a, b) in enumerate(zip(light.laws, dark.laws, strict=True))
    )
    # viser's widgets take their size from this one number of the Mantine library.
    root = f":root{{--duet-k:{k:g};--duet-dock:{DOCK_WIDTH * k:g}px;--mantine-scale:{k:g}!important}}"
    panel = "[data-floating-window]:has(.duet-plots)"
    narrow = (
        f"@media (max-width:{round(NARROW * k)}px){{"
        f"{panel} div:has(> div > .uplot-container){{grid-template-columns:var(--duet-narrow)!important}}"
        f"{panel} .mantine-Flex-root .mantine-Button-root{{padding:0 6px!important}}"
        f"{panel} div:has(> .duet-spare),{panel} div:has(> .duet-spare)+div{{display:none}}}}"
    )
    return f"<style>{root}{(STATIC / 'style.css').read_text(encoding='utf-8')}{colours}{narrow}</style>"
