"""The page's settings, and how settings are read and written: link, command line, header of an export."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final, Literal, NamedTuple

from controllers.errors import BadSetting
from scenes.laws import LAWS
from scenes.setting_spec import Tab, unknown_setting
from scenes.settings import ARMS, ARMS_PERSON, ELSEWHERE, RunSettings, changed, specs, values

Theme = Literal["light", "dark"]
Profile = Literal["desk", "projector"]
PictureQuality = Literal["fine", "fast"]
LANGUAGES: Final = {"en": "English", "de": "Deutsch", "sl": "Slovenščina"}
"""Language code → its own name. Texts are written in the first language; see `app/i18n/README.md`."""
TRANSLATIONS: Final = tuple(LANGUAGES)[1:]
"""Languages with a catalogue."""
LANGUAGE_LABELS: Final = {"auto": "As the browser asks", **LANGUAGES, "pseudo": "Pseudo (a test)"}
"""Choices of the page's language; `pseudo` is longer than all, to find clipped texts."""
Language = str
"""A key of `LANGUAGE_LABELS`."""
Details = Literal[
    "none",
    "lambda",
    "joints",
    "rates",
    "speeds",
    "follow",
    "curve",
    "laws",
    "map",
    "safety",
    "pairs",
    "stability",
    "microscope",
    "laps",
    "joint_laps",
]
"""λ, q, q̇ and speeds over time; desired and actual joints; λ(d); all laws; distance against error over n and
v, and by law; closest pair; section III; single steps; laps.
"""
Source = str
"""A built-in clip ("clips"), the figure in the 3-D view ("figure"), or a feature's source."""
BUILT_IN_SOURCES: Final = {"clips": "Built-in clip", "figure": "The figure: drag it"}


def ghosts() -> dict[str, str]:
    """Ghosts with the same inputs, value → label; features may add more."""
    laws = {name: law.short for name, law in LAWS.items()}
    return {"off": "Off", "frozen": "These settings, frozen", **laws}


BESIDE: Final = Tab("Compare")
LANGUAGE, LOOK = Tab("View"), Tab("View", 1)


@dataclass(frozen=True)
class PageSettings:
    """How the page looks and what moves at the start; none of it changes the simulation's numbers."""

    theme: Theme = LOOK.choice("light", Theme, "theme", "colours", "Light or dark.", "Light", "Dark")
    profile: Profile = LOOK.choice(
        "desk",
        Profile,
        "profile",
        "text",
        "Larger text and stronger lines for a projector.",
        "Desk",
        "Projector",
    )
    picture: PictureQuality = LOOK.choice(
        "fine",
        PictureQuality,
        "picture",
        "picture",
        "Fast leaves out shadows and reflections; a browser without a graphics card starts with it.",
        "Fine",
        "Fast",
    )
    language: Language = LANGUAGE.choice(
        "auto", LANGUAGE_LABELS.copy, "lang", "language", "Language of the page and of the lessons."
    )
    contact: bool = LOOK.flag(
        "contact",
        "show λ",
        "The line of contact, a skin as thick as d_m around the obstacle, and a purple tint of the arm that gives way.",
        True,
    )
    autopilot: bool = ARMS_PERSON.flag(
        "autopilot", "autopilot", "A seeded random person moves your arm until you take hold of it.", True
    )
    gizmo: bool = ARMS_PERSON.flag(
        "gizmo", "arrows", "Arrows and arcs that move your arm or the ball along one axis.", False
    )
    speed: float = ELSEWHERE.number(
        1.0, "speed", "speed", "Simulated seconds per second.", "", 0.25, 2.0, 0.25
    )
    details: Details = ELSEWHERE.choice(
        "none",
        Details,
        "plot",
        "more plots",
        "A third plot.",
        *(
            "None",
            "λ",
            "q",
            "q̇",
            "u v w",
            "q₁–q₄",
            "λ(d)",
            "Laws",
            "n, v",
            "e²(d)",
            "Pairs",
            "M",
            "dt",
            "laps",
            "laps of q",
        ),
    )
    ghost: str = BESIDE.choice(
        "off",
        ghosts,
        "ghost",
        "ghost",
        "A second, translucent run on the very same inputs: with the settings of this moment, or with another law.",
    )
    what_if: bool = BESIDE.flag(
        "whatif",
        "what if",
        "Moving d_m, n, v or K computes the last 20 s again and draws the new curves over the old ones.",
    )
    source: Source = ARMS.choice(
        "clips",
        BUILT_IN_SOURCES.copy,
        "source",
        "person",
        "Who is imitated.",
    )


class Look(NamedTuple):
    """The page's look; in a shared session every tab has its own."""

    theme: Theme
    profile: Profile
    picture: PictureQuality
    language: Language

    def of(self, page: PageSettings) -> PageSettings:
        return replace(page, **self._asdict())


LOOKS: Final = ("theme", "profile", "picture", "lang")


@dataclass(frozen=True)
class Settings:
    """The whole tree: the run and the page."""

    run: RunSettings = field(default_factory=RunSettings)
    page: PageSettings = field(default_factory=PageSettings)


def from_query(query: Mapping[str, str], start: Settings) -> tuple[Settings, tuple[str, ...]]:
    """Settings of a link, and a message for every impossible part, which is left out.

    Args:
        query: key → text, e.g. {"rig": "table", "dm": "0.1"}; SI units. Foreign keys are skipped.
        start: for settings that the link does not name, unless it is `WHOLE`.
    """
    problems: list[str] = []
    query = {mended_key(key): text for key, text in query.items()}
    if query.get(WHOLE) == "1":
        start = Settings()
    for key, text in query.items():
        if is_foreign(key):
            continue
        if key not in specs(Settings):
            problems.append(str(unknown_setting(key, (*specs(Settings), *LINK_KEYS))))
            continue
        try:
            start = changed(start, key, text)
        except BadSetting as error:
            problems.append(str(error))
    return start, tuple(problems)


def to_query(settings: Settings, but: Settings | None = None) -> dict[str, str]:
    """Query from which `from_query` restores these settings on any server. `but`: settings that the reader
    has; None for Duet's defaults.
    """
    known = values(but or Settings())
    changes = {key: value for key, value in values(settings).items() if value != known[key]}
    texts = {
        key: str(int(value)) if isinstance(value, bool) else str(value) for key, value in changes.items()
    }
    return {**texts, WHOLE: "1"}


WHOLE = "whole"
"""Key of a link that names every difference from Duet's defaults."""

STEP_KEYS: Final = frozenset({"lesson", "step"})
"""Keys of a link to a lesson."""

ALONE: Final = "alone"
"""Key of a teacher's page without a class, as in a notebook."""

MOTION: Final = "motion"
"""Key of a browser that prefers reduced motion."""

PANEL: Final = "panel"
"""Key of the number of controls: "small" or "all"."""

EMBED: Final = "embed"
"""Key of a page in another page's frame; see `embed.js`."""

JOIN: Final = "guest"
"""Key of a link to another visitor's session; its word leads to the worker process that announced it."""

PUSH: Final = "push"
"""Key of a visitor's push, replayed bit for bit; see `scenes.run_text`."""

ATTACK: Final = "attack"
"""Key of a run that breaks the promise, or nearly does."""

OPENED: Final = "opened"
"""Key of a random word for each load of the page; a new one in the same tab means a reload."""

LANGUAGES_KEY: Final = "languages"
"""Key of the visitor's languages, preferred first, as in the header Accept-Language."""

LINK_KEYS: Final = (*sorted(STEP_KEYS), PANEL, EMBED, PUSH, WHOLE)
"""Keys that people type, besides settings."""

FOREIGN_KEYS = frozenset(
    {
        "window",
        "folder",
        "websocket",
        "playbackPath",
        "darkMode",
        "key",
        "logCamera",
        "fixedDpr",
        "forceOrbitOriginTool",
    }
    | {"resume", WHOLE, ALONE, JOIN, ATTACK, PUSH, MOTION, OPENED, LANGUAGES_KEY, PANEL, EMBED}
    | STEP_KEYS
)
"""Keys that are not settings: viser's, a proxy's folder, and Duet's."""

APPENDED: Final = re.compile(
    # Campaigns of mailings, and what measures them.
    r"(utm|pk|mtm|piwik|matomo|hsa|gad|vero|oly|trk|_branch)_[a-z0-9_]+|__?hs[a-z]+|hsctatracking|mkt_tok|mc_[ce]id|_ke|_kx|s_cid|cid|"
    r"cmpid|ncid|_openstat|_ga|_gl|"
    # Clicks in search engines and social networks.
    r"[a-z]{0,3}clid|msclkid|gclsrc|gbraid|wbraid|srsltid|irclickid|li_fat_id|rdt_cid|igsh|igshid|mibextid|fb_[a-z_]+|__[a-z_]+(\[\d*\])?|"
    r"epik|spm|trk|si|usp|feature|isappinstalled|ref|ref_src|ref_url|referrer|"
    # Translators and learning platforms.
    r"_x_tr_[a-z]+|forceview|redirects|_xsrf|_t|_r",
    re.IGNORECASE,
)
"""Ignored keys that other services append to links."""


def mended_key(key: str) -> str:
    """Key without the rest of an HTML-escaped &amp;."""
    return _AMP.sub("", key)


_AMP: Final = re.compile(r"^(amp;)+", re.IGNORECASE)


def is_foreign(key: str) -> bool:
    """True if a key of a link is not a setting."""
    if key in specs(Settings):
        return False
    return key in FOREIGN_KEYS or key.startswith("initialCamera") or APPENDED.fullmatch(key) is not None


def asks_for_nothing(query: Mapping[str, str]) -> bool:
    """True if a link has no setting, lesson or run: its page begins as usual."""
    shown = (*STEP_KEYS, WHOLE, PUSH, ATTACK)
    keys = {mended_key(key) for key in query}
    return all(key in LOOKS or (is_foreign(key) and key not in shown) for key in keys)


def first_settings(
    query: Mapping[str, str], start: Settings, glides_as_usual: bool = True
) -> tuple[Settings, tuple[str, ...]]:
    """A new page's settings, and messages as of `from_query`.

    The arms of a usual page glide along what they meet, unless `glides_as_usual` is False; other links replay
    runs that may be older than that setting.
    """
    settings, problems = from_query(query, start)
    if glides_as_usual and asks_for_nothing(query) and start.run == RunSettings():
        settings = replace(settings, run=replace(settings.run, world=True))
    return settings, problems


def is_appended(key: str) -> bool:
    """True if a key was appended, and is not Duet's or viser's."""
    return key not in FOREIGN_KEYS and key not in specs(Settings) and APPENDED.fullmatch(key) is not None
