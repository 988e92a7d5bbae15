"""Every tab of a lecture has its own theme, profile, picture and language, and sees the same run."""

import itertools

from app.i18n.catalogue import words_of
from app.lessons.loading import load_lessons
from app.lessons.session.lesson_actions import GoOn
from app.lessons.translated_book import in_language
from app.settings import Language
from app.text.lesson_text import plain
from app.theme import PALETTES
from app.web.audiences import MOST
from tests.app.conftest import Join, OpenHouse, ask, lecture_of
from tests.app.page.helpers import Client, bodies, buttons, click, shown
from tests.blocking_client import BlockingClient

BOOK = load_lessons()
WAIT = 25.0
LESSON = next(i for i, lesson in enumerate(BOOK.lessons) if lesson.number == 1)


def says(visitor: BlockingClient, *words: str) -> None:
    visitor.wait_for(lambda _: all(word in shown(visitor) for word in words), WAIT)


def strokes(visitor: Client) -> set[tuple[str, float]]:
    plots = bodies(visitor, "GuiUplotMessage")
    return {(str(line["stroke"]), float(line["width"])) for plot in plots for line in plot["series"][1:]}


def test_every_tab_of_a_lecture_has_its_own_look_and_language(house: OpenHouse, join: Join) -> None:
    opened = house(lecture=True)
    host = lecture_of(opened)
    teacher = join(opened, f"resume={'1' * 32}", language="en")
    teacher.wait_for(lambda v: v.mirror.grabbable, WAIT)
    english, german = join(opened, language="en"), join(opened, "lang=de&picture=fast")
    screen = join(opened, "screen=1&profile=projector&theme=dark&lang=de")
    slovene = join(opened, language="sl, de;q=0.5")
    ask(host.session, lambda _: host.lessons.enter(LESSON))
    looks: list[tuple[BlockingClient, Language]] = [(english, "en"), (german, "de"), (screen, "de"), (slovene, "sl")]
    for visitor, language in looks:
        step = in_language(BOOK, language).lessons[LESSON].steps[0]
        theme, larger = ("dark", 1.3) if visitor is screen else ("light", 1.0)
        says(visitor, plain(step.title), words_of(language)("Goal"), f"--duet-k:{larger:g}")
        visitor.wait_for(lambda v, theme=theme: PALETTES[theme].error in {colour for colour, _ in strokes(v)}, WAIT)
        assert 2.2 * larger in {width for _, width in strokes(visitor)}
        assert bool(visitor.mirror.nodes["/light/sky"].get("visible", True)) == (visitor is german)
        if visitor is not screen:
            # The palette's names and the buttons of the answers are in the language of the tab too.
            assert step.question is not None
            name, answer = words_of(language)("Answer {number}", number=1), f"1   {plain(step.question.choices[0].text)}"
            visitor.wait_for(lambda v, name=name: name in {c["label"] for c in list(v.mirror.commands.values())}, WAIT)
            visitor.wait_for(lambda v, answer=answer: answer in buttons(v), WAIT)
    assert not screen.mirror.commands
    # What the teacher chooses for the own page stays there, and the lesson goes on where it is.
    steps = ask(host.session, lambda _: host.lessons.walk.run_id)
    ask(host.session, lambda s: [s.change("lang", "sl"), s.change("theme", "dark"), s.change("profile", "projector")])
    says(teacher, plain(in_language(BOOK, "sl").lessons[LESSON].steps[0].title), "--duet-k:1.3")
    teacher.wait_for(lambda v: PALETTES["dark"].error in {colour for colour, _ in strokes(v)}, WAIT)
    assert "--duet-k:1.3" not in shown(english) and ask(host.session, lambda _: host.lessons.walk.run_id) == steps
    says(english, plain(BOOK.lessons[LESSON].steps[0].title))
    # The class's answers and the outcome, in every language.
    click(german, "1   ")
    walk = host.lessons.walk
    place = walk.lesson.id, walk.step.id
    teacher.wait_for(lambda _: host.room.ballots.tally(place, 3, host.room.here).answered == 1, WAIT)
    host.control.post("reveal")
    ask(host.session, lambda _: host.lessons.act(GoOn()))
    for visitor, language in looks:
        says(visitor, words_of(language)("The class said"), words_of(language)("Measured"))


def test_what_a_look_shows_is_packed_once_and_forgotten_with_its_last_watcher(house: OpenHouse, join: Join) -> None:
    opened = house(lecture=True)
    host = lecture_of(opened)
    join(opened)
    ann, bo, cy = join(opened, "lang=de"), join(opened, "lang=de&dm=0.3"), join(opened, "lang=de&theme=dark")
    cy.wait_for(lambda _: len(host.stage.pages) == 2, WAIT)
    assert sorted(len(audience.watchers) for audience in host.audiences.audiences) == [1, 2]
    ann.close()
    cy.wait_for(lambda _: [len(one.watchers) for one in host.audiences.audiences] == [1, 1], WAIT)
    bo.close()
    cy.wait_for(lambda _: len(host.stage.pages) == 1, WAIT)
    # So many looks are drawn; more of them join the one that is most like theirs, in their language.
    every = itertools.product(("sl", "en"), ("light", "dark"), ("desk", "projector"))
    looks = [f"lang={lang}&theme={theme}&profile={size}" for lang, theme, size in every]
    # Each is a tab of its own, as without an id one address has few connections.
    others = [join(opened, f"{look}&resume={number:016d}") for number, look in enumerate(looks)]
    assert len(host.audiences.audiences) == MOST and len(looks) + 1 > MOST
    more = join(opened, f"lang=de&theme=dark&picture=fast&resume={'f' * 16}")
    says(more, 'data-words="de"')
    assert len(host.audiences.audiences) == MOST and all(one.closed is None for one in others)
    assert opened.server.count_clients() == 11, "a lecture has room for more pages than there are private sessions"
