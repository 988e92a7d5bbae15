from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.feature import Feature
from app.i18n.speaking import N_
from app.text.document_list import DocumentFile

STATIC: Final = Path(__file__).parent / "static"

if TYPE_CHECKING:
    from app.features.lecture.lecture_options import LectureOptions
    from app.hosting.app_context import AppContext
    from app.hosting.host import Host
    from app.web.pages import PageAssets


def _assets() -> "PageAssets":
    from app.web.pages import PageAssets

    scripts = STATIC / "class_holders.js", STATIC / "presenter.js"
    return PageAssets(scripts, (STATIC / "lecture.css", STATIC / "presenter.css"))


def _options() -> "type[LectureOptions]":
    from app.features.lecture.lecture_options import LectureOptions

    return LectureOptions


def _host(context: "AppContext") -> "Host | None":
    if not context.options.of(_options()).lecture:
        return None
    import logging
    from dataclasses import replace

    from app.features.lecture.breakout_host import BreakoutHost
    from app.features.lecture.lecture import LectureHost
    from app.features.workers.worker_messages import WorkerLink
    from app.runtime.throttled_log import ThrottledLog

    context = replace(context, errors=ThrottledLog(logging.getLogger("duet.lecture")))
    link = context.given(WorkerLink)
    return LectureHost(context, link) if link is None or link.index == 0 else BreakoutHost(context, link)


_HERE: Final = Path(__file__).parent

_DOCUMENTS: Final = {
    "class": DocumentFile(_HERE / "class.md", N_("For a class")),
    "lecture-plan": DocumentFile(_HERE / "lecture-plan.md", N_("A lecture plan")),
}

LECTURE: Final = Feature(
    "lecture", texts=_HERE, documents=_DOCUMENTS, assets=_assets, options=_options, host=_host
)
