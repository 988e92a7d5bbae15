"""Each tab has its theme, profile, picture and language; data for tabs of one look is packed once."""

import itertools
from dataclasses import dataclass

import pytest

from app.features.lecture.audiences import MOST
from app.features.lecture.lecture import LectureHost
from app.features.lessons.session.lesson_actions import Press
from app.i18n.catalogue import words_of
from app.settings import Language, Theme
from app.start import App
from app.text.lesson_text import plain
from app.theme import PALETTES
from tests.app.conftest import Join, OpenHouse, ask
from tests.app.features.lecture.lecture_room import WAIT, lecture_of, sees
from tests.app.features.lessons.helpers import our_book
from tests.app.page.helpers import Client, bodies, buttons, click, shown
from tests.blocking_client import BlockingClient

pytestmark = pytest.mark.thorough

BOOK = our_book()
LESSON = next(i for i, lesson in enumerate(BOOK.lessons) if lesson.number == 1)
LEADER = f"resume={'1' * 32}"


def strokes(visitor: Client) -> set[tuple[str, float]]:
    plots = bodies(visitor, "GuiUplotMessage")
    return {(str(line["stroke"]), float(line["width"])) for plot in plots for line in plot["series"][1:]}


def has_the_theme(visitor: BlockingClient, theme: Theme) -> None:
    visitor.wait_for(lambda v: PALETTES[theme].error in {colour for colour, _ in strokes(v)}, WAIT)


@dataclass(frozen=True)
class Looks:
    """A teacher in lesson 1, and tabs in three languages, one of them a projector."""

    opened: App
    host: LectureHost
    teacher: BlockingClient
    english: BlockingClient
    german: BlockingClient
    screen: BlockingClient
    slovene: BlockingClient

    @property
    def languages(self) -> list[tuple[BlockingClient, Language]]:
        return [(self.english, "en"), (self.german, "de"), (self.screen, "de"), (self.slovene, "sl")]


@pytest.fixture
def looks(house: OpenHouse, join: Join) -> Looks:
    opened = house(lecture=True)
    host = lecture_of(opened)
    teacher = join(opened, LEADER, headers={"Accept-Language": "en"})
    teacher.wait_for(lambda v: v.mirror.grabbable, WAIT)
    made = Looks(
        opened,
        host,
        teacher,
        english=join(opened, headers={"Accept-Language": "en"}),
        german=join(opened, "lang=de&picture=fast"),
        screen=join(opened, "screen=1&profile=projector&theme=dark&lang=de"),
        slovene=join(opened, headers={"Accept-Language": "sl, de;q=0.5"}),
    )
    ask(host.session, lambda _: host.lessons.enter(BOOK.lessons[LESSON].id))
    return made


def test_every_tab_has_its_own_theme_size_picture_and_language(looks: Looks) -> None:
    for visitor, language in looks.languages:
        step = BOOK.in_language(language).lessons[LESSON].steps[0]
        theme, larger = ("dark", 1.3) if visitor is looks.screen else ("light", 1.0)
        sees(visitor, plain(step.title), words_of(language)("Goal"), f"--duet-k:{larger:g}")
        has_the_theme(visitor, theme)
        assert 2.2 * larger in {width for _, width in strokes(visitor)}
        lit = visitor is looks.german
        visitor.wait_for(
            lambda v, lit=lit: bool(v.mirror.nodes.get("/light/sky", {}).get("visible", True)) == lit, WAIT
        )


def test_palette_and_answers_are_in_the_language_of_the_tab(looks: Looks) -> None:
    for visitor, language in looks.languages:
        question = BOOK.in_language(language).lessons[LESSON].steps[0].question
        assert question is not None
        if visitor is looks.screen:
            continue
        name, answer = (
            words_of(language)("Answer {number}", number=1),
            f"1   {plain(question.choices[0].text)}",
        )
        visitor.wait_for(
            lambda v, name=name: name in {c["label"] for c in list(v.mirror.commands.values())}, WAIT
        )
        visitor.wait_for(lambda v, answer=answer: answer in buttons(v), WAIT)
    assert not looks.screen.mirror.commands


def test_the_teachers_page_settings_affect_only_that_page(looks: Looks) -> None:
    host, first_step = looks.host, BOOK.lessons[LESSON].steps[0]
    sees(looks.english, plain(first_step.title))
    run = ask(host.session, lambda _: host.lessons.walk.run_id)
    ask(
        host.session,
        lambda s: [s.change("lang", "sl"), s.change("theme", "dark"), s.change("profile", "projector")],
    )
    sees(looks.teacher, plain(BOOK.in_language("sl").lessons[LESSON].steps[0].title), "--duet-k:1.3")
    has_the_theme(looks.teacher, "dark")
    assert "--duet-k:1.3" not in shown(looks.english)
    assert ask(host.session, lambda _: host.lessons.walk.run_id) == run, "the lesson's run is the same"
    sees(looks.english, plain(first_step.title))


def test_answers_of_the_class_and_the_outcome_are_in_every_language(looks: Looks) -> None:
    host = looks.host
    click(looks.german, "1   ")
    walk = host.lessons.walk
    place = walk.lesson.id, walk.step.id
    looks.teacher.wait_for(lambda _: host.classroom.ballots.counts(place, 3, ()).newest.answered == 1, WAIT)
    host.control.post("reveal")
    ask(host.session, lambda _: host.lessons.act(Press("next")))
    for visitor, language in looks.languages:
        sees(visitor, words_of(language)("The class said"), words_of(language)("Measured"))


def watchers(host: LectureHost) -> list[int]:
    """Numbers of tabs per look."""
    return sorted(len(audience.watchers) for audience in host.audiences.audiences)


def test_a_look_is_packed_once_until_its_last_watcher_leaves(looks: Looks, join: Join) -> None:
    bo = join(looks.opened, "lang=de&picture=fast&dm=0.3")
    assert watchers(looks.host) == [1, 1, 1, 2]
    looks.german.close()
    bo.wait_for(lambda _: watchers(looks.host) == [1, 1, 1, 1], WAIT)
    for one in (looks.english, looks.screen):
        one.close()
    bo.wait_for(lambda _: len(looks.host.shared.pages) == 2, WAIT)


def test_a_look_beyond_the_limit_joins_the_most_similar_one(house: OpenHouse, join: Join) -> None:
    opened = house(lecture=True)
    audiences = lecture_of(opened).audiences
    join(opened, LEADER)
    every = itertools.product(("sl", "en"), ("light", "dark"), ("desk", "projector"))
    looks = ["lang=de&theme=light", *(f"lang={a}&theme={b}&profile={c}" for a, b, c in every)]
    assert len(looks) > MOST
    # Each has a tab id, because without one an address is limited to few connections.
    others = [join(opened, f"{look}&resume={number:016d}") for number, look in enumerate(looks)]
    assert len(audiences.audiences) == MOST
    last = join(opened, f"lang=de&theme=dark&picture=fast&resume={'f' * 16}")
    sees(last, 'data-words="de"')
    assert len(audiences.audiences) == MOST and all(one.closed is None for one in others)
    # A place is taken and released with a delay.
    last.wait_for(lambda _: opened.server.count_clients() == len(looks) + 2, WAIT)
