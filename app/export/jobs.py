"""Jobs of the exports: their language, and the names of the files."""

from typing import Any

from app.export.player import player_html
from app.i18n.speaking import set_language
from app.settings import Language
from scenes.inputs import Recorded


def picture(language: Language, *arguments: Any) -> bytes:
    """Return `app.export.plot_pictures.picture_bytes` of the arguments. Imports matplotlib in the worker only."""
    from app.export.plot_pictures import picture_bytes

    set_language(language)
    return picture_bytes(*arguments)


def player(language: Language, *arguments: Any) -> bytes:
    """Return `app.export.player.player_html` of the arguments."""
    set_language(language)
    return player_html(*arguments)


def push_film(language: Language, *arguments: Any) -> bytes:
    """Return `app.export.push_film.film_bytes` of the arguments. Imports what draws in the worker only."""
    from app.export.push_film import film_bytes

    set_language(language)
    return film_bytes(*arguments)


def file_name(recorded: Recorded, seconds: float) -> str:
    """Return a name without its ending: scene and times."""
    end = recorded.begin + recorded.seconds
    begin = max(recorded.begin, end - seconds)
    return f"duet-{recorded.settings.scene}-{begin:.0f}-{end:.0f}s"
