"""A lecture: one plenary session for the whole class, the teacher's control of it, polls, and breakout sessions."""

from typing import TYPE_CHECKING, Final

from app.feature import Feature

if TYPE_CHECKING:
    from app.hosting.app_context import AppContext
    from app.hosting.host import Host


def _host(context: "AppContext") -> "Host | None":
    if not context.options.lecture:
        return None
    from app.features.lecture.breakout_host import BreakoutHost
    from app.features.lecture.lecture import LectureHost

    if context.link is None or context.link.index == 0:
        return LectureHost(context)
    return BreakoutHost(context, context.link)


LECTURE: Final = Feature("lecture", host=_host)
