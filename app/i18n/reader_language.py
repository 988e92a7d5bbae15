"""Which language a visitor reads, by what their browser says."""

from collections.abc import Mapping

from app.i18n.catalogue import Words
from app.i18n.client_texts import client_script
from app.settings import LOOKS, Language, Look, Settings, from_query

KNOWN: tuple[Language, ...] = ("en", "de", "sl")
"""What a browser can ask for."""


def preferred(accept: str) -> Language:
    """Return the language of ours that a browser likes best, by its header `Accept-Language` (RFC 9110, 12.5.4): English if none.

    A region does not matter: de-AT is German. What is equally liked counts in the order given.
    """
    best: tuple[float, Language] = (0.0, "en")
    for entry in accept[:1000].split(","):
        tag, _, weight = entry.partition(";")
        name = tag.strip().lower().split("-")[0]
        found: Language | None = next((one for one in KNOWN if name in (one, "*")), None)
        liking = _quality(weight)
        if found is not None and liking > best[0]:
            best = liking, found
    return best[1]


def _quality(text: str) -> float:
    """Return the number behind `q=`, 1 without one, 0 for what is none."""
    name, mark, number = text.strip().partition("=")
    if not name and not mark:
        return 1.0
    try:
        quality = float(number)
    except ValueError:
        return 0.0
    return quality if name.strip().lower() == "q" and 0.0 <= quality <= 1.0 else 0.0


def language_of(settings: Settings, browser: Language) -> Language:
    """Return what a page speaks: the language that was chosen, by link or on the page, or the one that the browser likes best."""
    return browser if settings.page.language == "auto" else settings.page.language


def look_of(query: Mapping[str, str], browser: Language, start: Settings) -> Look:
    """Return how a tab of a lecture is to look.

    Args:
        query: of its link; what is not possible there is left out.
        browser: the language that its browser likes best.
        start: what the link does not say.
    """
    settings = from_query({key: query[key] for key in LOOKS if key in query}, start)[0]
    return Look(settings.page.theme, settings.page.profile, settings.page.picture, language_of(settings, browser))


def language_asked(query: Mapping[str, str], accept: str) -> Language:
    """Return the language of a page that belongs to no session: what its link asks for, or what the browser likes best.

    Args:
        query: of the link.
        accept: header of the request.
    """
    known: dict[str, Language] = {"pseudo": "pseudo", **{one: one for one in KNOWN}}
    return known.get(query.get("lang", "")) or preferred(accept)


def mark_html(words: Words) -> str:
    """Return what tells the page which language it is in; see `language_script`."""
    named = "en" if words.language == "pseudo" else words.language
    return f'<i class="duet-language" data-language="{named}" data-words="{words.language}"></i>'


def language_script() -> str:
    """Return JavaScript that says what the browser says by itself in the page's language, see `app.i18n.client_texts`, and keeps the
    page's own `lang` right, by which a screen reader finds its voice."""
    return client_script() + (
        "setInterval(()=>{const found=document.querySelector('.duet-language')?.dataset;if(!found)return;"
        "if(document.documentElement.lang!==found.language)document.documentElement.lang=found.language;"
        "duetSpeak(found.words);},500);"
    )
