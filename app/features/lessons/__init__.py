from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.feature import Command, Feature
from app.features.lessons.folder import FOLDER
from app.i18n.speaking import N_
from app.text.document_list import DocumentFile

_HERE: Final = Path(__file__).parent

_STATIC: Final = _HERE / "static"
if TYPE_CHECKING:
    from app.features.lessons.lesson_options import LessonOptions
    from app.hosting.app_context import AppContext
    from app.hosting.server_part import ServerPart
    from app.page.panel_context import PanelMaker
    from app.page.panels.hotkeys import KeyHelp
    from app.page.view import View, ViewPart
    from app.web.pages import PageAssets


def _commands() -> Mapping[str, Command]:
    from app.features.lessons.commands import Lessons, NewLesson, lessons, new_lesson

    return {
        "lessons": Command(Lessons, lessons, "teach"),
        "new-lesson": Command(NewLesson, new_lesson, "teach"),
    }


def _options() -> "type[LessonOptions]":
    from app.features.lessons.lesson_options import LessonOptions

    return LessonOptions


def _panels() -> "Sequence[PanelMaker]":
    from app.features.lessons.panel.lesson_controls import LessonControls

    return (LessonControls,)


def _key_help() -> "Sequence[KeyHelp]":
    from app.features.lessons.panel.lesson_keys import key_help

    return key_help()


def _overlays() -> "Sequence[Callable[[View], ViewPart]]":
    from app.features.lessons.panel.lesson_view import LessonView

    return (LessonView,)


def _assets() -> "PageAssets":
    from app.web.pages import PageAssets

    return PageAssets((_STATIC / "welcome.js",), (_STATIC / "welcome.css",))


def _server(context: "AppContext") -> "ServerPart":
    from app.features.lessons.panel.lesson_visit import LessonServer

    return LessonServer(context)


LESSONS: Final = Feature(
    "lessons",
    texts=_HERE,
    documents={"lessons": DocumentFile(FOLDER / "README.md", N_("How to write a lesson"))},
    commands=_commands,
    panels=_panels,
    key_help=_key_help,
    overlays=_overlays,
    assets=_assets,
    options=_options,
    server=_server,
)
