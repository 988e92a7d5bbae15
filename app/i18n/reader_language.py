"""A visitor's language, by link, page or browser."""

from collections.abc import Mapping

from app.i18n.catalogue import Words
from app.settings import LANGUAGES, LOOKS, Language, Look, Settings, from_query


def preferred(accept: str) -> Language:
    """Preferred known language by a header `Accept-Language` (RFC 9110, 12.5.4); English if none is known.

    The region is ignored: de-AT is German. Among equal qualities the first one counts.
    """
    best: tuple[float, Language] = (0.0, "en")
    for entry in accept[:1000].split(","):
        tag, _, weight = entry.partition(";")
        name = tag.strip().lower().split("-")[0]
        found: Language | None = next((one for one in LANGUAGES if name in (one, "*")), None)
        quality = _quality(weight)
        if found is not None and quality > best[0]:
            best = quality, found
    return best[1]


def _quality(text: str) -> float:
    """Number after `q=`: 1 if missing, 0 if invalid."""
    name, mark, number = text.strip().partition("=")
    if not name and not mark:
        return 1.0
    try:
        quality = float(number)
    except ValueError:
        return 0.0
    return quality if name.strip().lower() == "q" and 0.0 <= quality <= 1.0 else 0.0


def language_of(settings: Settings, browser: Language) -> Language:
    return browser if settings.page.language == "auto" else settings.page.language


def look_of(query: Mapping[str, str], browser: Language, start: Settings) -> Look:
    """Look of a tab that watches a shared session, without impossible values. `start`: settings that the
    query leaves open.
    """
    settings = from_query({key: query[key] for key in LOOKS if key in query}, start)[0]
    return Look(
        settings.page.theme, settings.page.profile, settings.page.picture, language_of(settings, browser)
    )


def language_asked(query: Mapping[str, str], accept: str) -> Language:
    """Language of a page without a session: its link's, or by the header `Accept-Language`."""
    asked = query.get("lang", "")
    return asked if asked in (*LANGUAGES, "pseudo") else preferred(accept)


def mark_html(words: Words) -> str:
    """Hidden HTML with the page's language, for `page_language.js`."""
    named = "en" if words.language == "pseudo" else words.language
    return f'<i class="duet-language" data-language="{named}" data-words="{words.language}"></i>'
