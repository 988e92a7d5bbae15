"""What visitors left behind: for their own tab, for a while, and for a bounded number of them."""

import math
from typing import cast

import pytest

from app.hosting.resume import open_link
from app.hosting.session_store import AWAY, MOST_RECORDS, MOST_SESSIONS, SessionStore
from app.hosting.visitor_record import VisitorRecord, same_tab
from app.lessons.loading import load_lessons
from app.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from app.settings import Settings
from scenes.settings import changed
from tests.app.stores import find

TAB = "0123456789abcdef0123456789abcdef"
LINK = {"resume": TAB, "dm": "0.2", "window": "800x600"}
LESSONS = cast(LessonSession, None)


class NotedSession(Session):
    closed = False

    def close(self) -> None:
        self.closed = True


def test_a_live_session_is_claimed_once_by_its_own_tab_and_link_for_ten_minutes() -> None:
    now = 0.0
    store = SessionStore(clock=lambda: now)

    def park(query: dict[str, str]) -> NotedSession:
        session = NotedSession(Settings())
        store.park(query, session, LESSONS)
        return session

    assert AWAY == 600.0
    session = park(LINK)
    now = AWAY
    store.save(VisitorRecord(LINK, Settings(), None))
    assert find(store, LINK) is None, "nothing is read where the live session waits"
    claimed = store.claim({**LINK, "window": "390x844"})
    assert find(store, LINK) is not None
    assert claimed is not None and claimed[0] is session and store.parked == 0 and store.claim(LINK) is None
    session = park(LINK)
    now += AWAY + 0.1
    assert store.claim(LINK) is None and session.closed, "too late"
    session = park(LINK)
    assert store.claim({**LINK, "dm": "0.3"}) is None and session.closed, "another link"
    assert park({"dm": "0.2"}).closed and park({"resume": "../../etc"}).closed and store.parked == 0, "no valid tab"
    sessions = []
    for number in range(MOST_SESSIONS + 2):
        now += 1.0
        sessions.append(park({"resume": f"{number:016d}"}))
    assert [one.closed for one in sessions] == [True] * 2 + [False] * MOST_SESSIONS
    again = park({"resume": f"{5:016d}"})
    assert sessions[5].closed and store.parked == MOST_SESSIONS
    now += AWAY - 5.5
    store.tidy()
    assert [one.closed for one in sessions] == [True] * 4 + [False, True] + [False] * 4
    store.close()
    assert store.parked == 0 and again.closed and all(one.closed for one in sessions)
    assert same_tab(LINK, {**LINK, "window": "1x1"}) and not same_tab({}, {}) and not same_tab(LINK, {"resume": TAB})


@pytest.mark.parametrize("keep", [AWAY, math.inf])
def test_a_record_is_found_by_its_own_tab_with_any_link(keep: float) -> None:
    now = 0.0
    store = SessionStore(keep, lambda: now)
    mine, theirs = (
        VisitorRecord({"resume": tab}, changed(Settings(), "dm", dm), None) for tab, dm in ((TAB, 0.11), ("f" * 16, 0.22))
    )
    for record in (mine, theirs, VisitorRecord({"resume": "../../etc"}, Settings(), None)):
        store.save(record)
    now = AWAY - 1.0
    assert find(store, {**LINK, "lesson": "4"}) is mine and find(store, theirs.query) is theirs
    assert find(store, {"resume": TAB[::-1]}) is find(store, {}) is find(store, {"resume": "../../etc"}) is None
    now = AWAY + 1.0
    assert (find(store, LINK) is mine) == (keep == math.inf)
    for number in range(MOST_RECORDS):
        store.save(VisitorRecord({"resume": f"{number:016d}"}, Settings(), None))
    assert find(store, LINK) is None and find(store, {"resume": f"{0:016d}"}) is not None


@pytest.mark.parametrize(("lesson", "open"), [("3", True), ("4", False)])
def test_by_the_same_lesson_link_a_tab_is_where_it_was_and_by_another_one_keeps_its_progress(lesson: str, open: bool) -> None:
    book = load_lessons()
    run = LessonSession(Session(Settings()), book)
    run.enter(2)
    run.walk.choose(1)
    place = run.walk.lesson.id, run.walk.step.id
    back = LessonSession(Session(Settings()), book)
    assert open_link(back, {"lesson": lesson}, VisitorRecord({"lesson": "3"}, Settings(), run.saved())) == ()
    assert back.walk.done_in(*place).choice == 1 and ((back.walk.lesson.id, back.walk.step.id) == place) == open
