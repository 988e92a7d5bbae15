"""How a session takes on the settings of a lesson, and gets the visitor's own ones back."""

from dataclasses import replace
from typing import Final

from app.session import Session
from app.settings import Settings
from controllers.errors import BadSetting
from scenes.settings import values

_KEPT_LOOK: Final = ("theme", "profile", "picture", "language")


def with_look(settings: Settings, session: Session) -> Settings:
    """Return settings with the look that the page has now: a lesson does not change how the visitor likes to see it."""
    look = {name: getattr(session.settings.page, name) for name in _KEPT_LOOK}
    return replace(settings, page=replace(settings.page, **look))


def adopt(session: Session, settings: Settings) -> str:
    """Take on settings, whatever order makes them possible one by one; return what was not possible, "" if all was."""
    wanted = values(settings)
    problem = ""
    for _ in range(3):
        refused = ""
        for key, value in wanted.items():
            if values(session.settings)[key] == value:
                continue
            try:
                session.change(key, value)
            except BadSetting as error:
                refused = str(error)
        if not refused:
            return ""
        problem = refused
    return problem
