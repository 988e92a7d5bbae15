"""A link: it gives the settings again, leads to the lesson, and says the address that the browser knows."""

from urllib.parse import parse_qsl, urlencode, urlsplit

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.hosting.resume import open_link
from app.lessons.loading import load_lessons
from app.lessons.session.lesson_session import LessonSession
from app.page.panels.link_box import link_query, link_to
from app.session.session import Session
from app.settings import WHOLE, Settings, from_query, to_query
from app.web.index_page import page_query
from scenes.setting_spec import Spec
from scenes.settings import changed, specs, values


def a_value(spec: Spec, present: object) -> st.SearchStrategy[object]:
    if spec.choices:
        return st.sampled_from(spec.choices)
    if isinstance(present, bool):
        return st.booleans()
    if isinstance(present, int):
        return st.integers(int(spec.low), int(spec.high))
    return st.floats(spec.low, spec.high)


@st.composite
def any_settings(draw: st.DrawFn) -> Settings:
    settings, present, known = Settings(), values(Settings()), specs(Settings)
    for key in draw(st.sets(st.sampled_from(list(known)))):
        settings = changed(settings, key, draw(a_value(known[key], present[key])))
    return settings


@given(any_settings(), any_settings())
def test_a_link_gives_the_same_settings_whatever_the_server_was_started_with(settings: Settings, start: Settings) -> None:
    path = urlsplit(link_to("http://a", to_query(settings)))
    assert from_query(page_query(f"{path.path}?{path.query}"), start) == (settings, ())


@given(any_settings(), any_settings())
def test_what_is_known_need_not_be_said(settings: Settings, known: Settings) -> None:
    said = to_query(settings, known)
    del said[WHOLE]
    assert from_query(said, known) == (settings, ())
    assert len(said) == sum(values(settings)[key] != value for key, value in values(known).items())


def test_what_is_as_at_first_is_not_said() -> None:
    assert to_query(Settings()) == {WHOLE: "1"}
    assert to_query(changed(changed(Settings(), "dm", 0.1), "autopilot", False)) == {"dm": "0.1", "autopilot": "0", WHOLE: "1"}
    # Without the word a link leaves alone what it does not say.
    start = changed(Settings(), "rig", "table")
    assert from_query({"dm": "0.1"}, start)[0].run.rig == "table"


@pytest.mark.parametrize(("step", "key", "value"), [(0, "k", 5.0), (2, "k", 0.5)])
def test_a_link_into_a_lesson_opens_its_step_with_what_was_changed_there(step: int, key: str, value: float) -> None:
    book = load_lessons()
    session = Session(changed(Settings(), "dm", 0.2))
    run = LessonSession(session, book)
    run.enter(0, step)
    session.change(key, value)
    session.change("theme", "dark")
    query = link_query(session.settings, run)
    assert query == {"lesson": book.lessons[0].id, "step": str(step + 1), key: str(value), "theme": "dark", WHOLE: "1"}

    query = dict(parse_qsl(urlencode(query)))
    settings, problems = from_query(query, Settings())
    there = Session(settings)
    again = LessonSession(there, book)
    assert (problems, open_link(again, query, None)) == ((), ())
    assert (again.walk.lesson, again.walk.step) == (run.walk.lesson, run.walk.step)
    assert there.settings == session.settings
