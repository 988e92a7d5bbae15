"""A lecture: all see the same run, each tab in its own theme, profile, picture and language, and one has the controls."""

import itertools
import threading
from typing import Any

import pytest

from app.features.lecture.audiences import MOST
from app.features.lecture.leader import Leader
from app.features.lessons.session.lesson_actions import Press
from app.hosting.teacher_key import LONGEST, MOST_ADDRESSES, Guesses
from app.i18n.catalogue import words_of
from app.page.panels.hotkeys import hotkeys
from app.session.session import Session
from app.settings import Language, Settings
from app.text.lesson_text import plain
from app.theme import PALETTES
from app.web.headless_client import CAMERA
from tests.app.conftest import Join, Made, OpenHouse, ask
from tests.app.features.lecture.lecture_room import WAIT, lecture_of, operator_of, sees, tab_of
from tests.app.features.lessons.helpers import our_book
from tests.app.page.by_hand import WRIST
from tests.app.page.helpers import Client, bodies, buttons, click, hotkey_uuid, open_lessons, shown
from tests.app.runtime.processes import until
from tests.blocking_client import BlockingClient

LEADER = f"resume={'1' * 32}"
LINK = f"/arms/right{WRIST}"


def has_controls(visitor: BlockingClient) -> bool:
    operated = {f"Gui{kind}Message" for kind in ("Slider", "Dropdown", "Checkbox", "Number", "ButtonGroup")}
    return bool(
        operated & {element["type"] for element in list(visitor.mirror.gui.values())}
        or visitor.mirror.commands
        or visitor.mirror.grabbable
    )


def test_a_lecture_shows_all_the_same_and_obeys_one(house: OpenHouse, join: Join) -> None:
    opened = house(lecture=True)
    host, session = lecture_of(opened), lecture_of(opened).session
    first = join(opened, LEADER)
    first.wait_for(lambda v: len(v.mirror.commands) >= len(hotkeys()) and LINK in v.mirror.grabbable)
    second = join(opened, "dm=0.3")
    assert session.settings == Settings()
    for visitor in (first, second):
        visitor.wait_for(lambda v: len(bodies(v, "GuiUplotMessage")) == 2)
    first.send({"type": "CommandTriggerMessage", "uuid": hotkey_uuid(first, "pause")})
    first.wait_for(lambda _: session.paused)
    assert has_controls(first) and not has_controls(second)
    assert operator_of(host) == int(first.mirror.nodes[LINK]["owner"])

    # The second one knows all the names, and it is of no use.
    open_lessons(first)
    first.wait_for(lambda v: "Run (predict first)" in buttons(v))

    def state(s: Session) -> tuple[object, ...]:
        classroom, lessons = host.classroom, host.lessons
        return (
            s.settings,
            s.paused,
            s.held,
            s.simulation.steps,
            classroom.free,
            classroom.paused,
            lessons.open,
            lessons.walk.to_json(),
        )

    before, elements = ask(session, state), list(first.mirror.gui.values())
    for owner in (str(operator_of(host)), "", str(int(operator_of(host) or 0) + 1)):
        target = {
            "type": "SceneNodeDragMessage",
            "name": LINK,
            "owner": owner,
            "instance_index": None,
            "button": "left",
        }
        places = {"start_position": [0.3, 0.0, 1.0], "end_position": [0.0, 0.0, 1.0], "modifier": None}
        for phase in ("start", "update", "end"):
            second.send(
                {
                    **target,
                    **places,
                    "phase": phase,
                    "start_screen_pos": [0.5, 0.5],
                    "end_screen_pos": [0.5, 0.5],
                }
            )
    values = {
        "GuiSliderMessage": [50.0],
        "GuiButtonGroupMessage": ["Reset", "Reset step", "Explore freely"],
        "GuiButtonMessage": [True],
    }
    for uuid, value in ((e["uuid"], value) for e in elements for value in values.get(e["type"], [])):
        second.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": value}})
    for uuid in list(first.mirror.commands):
        second.send({"type": "CommandTriggerMessage", "uuid": uuid})
    # The camera is everybody's own: once it has arrived, all of the above has, too.
    second.wait_for(lambda _: len(opened.server.get_clients()) == 2)
    known = opened.server.get_clients()
    (own,) = (client for number, client in known.items() if number != operator_of(host))
    second.send(CAMERA | {"image_height": 500, "image_width": 700})
    second.wait_for(lambda _: own.camera.image_width == 700)
    assert ask(session, state) == before
    # The first one can.
    click(first, "Leave the lessons")
    click(first, "Leave with the class")
    first.wait_for(lambda v: LINK in v.mirror.grabbable)
    first.set_value("critical distance d_m [mm]", 50.0)
    first.wait_for(lambda _: session.settings.run.law.critical_distance == 0.05)

    # It leaves in mid-drag: the hand is let go, and neither who is there nor who comes now takes over.
    first.pull(LINK, "start", [0.3, 0.0, 1.0], [0.3, 0.0, 1.1])
    first.wait_for(lambda _: session.held is not None)
    operator = operator_of(host)
    first.close()
    second.wait_for(lambda _: host.controls.operator is None)
    third = join(opened, f"resume={'3' * 32}")
    third.wait_for(lambda _: len(host.classroom.here) == 2)
    assert (
        host.controls.operator is None
        and session.held is None
        and not has_controls(second)
        and not has_controls(third)
    )
    # It is back, before its next connection breaks off is noticed, too.
    again = join(opened, LEADER)
    again.wait_for(lambda v: LINK in v.mirror.grabbable and len(v.mirror.commands) >= len(hotkeys()))
    back = join(opened, LEADER)
    back.wait_for(lambda v: LINK in v.mirror.grabbable and len(v.mirror.commands) >= len(hotkeys()))
    assert operator_of(host) == int(back.mirror.nodes[LINK]["owner"]) != operator
    back.set_value("critical distance d_m [mm]", 100.0)
    back.send({"type": "CommandTriggerMessage", "uuid": hotkey_uuid(back, "pause")})
    back.wait_for(lambda _: session.settings.run.law.critical_distance == 0.1 and session.paused)
    assert not has_controls(second) and not has_controls(third)


def test_without_a_key_the_lead_is_kept_for_a_minute_and_is_no_students() -> None:
    now = 0.0
    lead, (ann, bo, cy, *others) = (
        Leader(None, clock=lambda: now),
        ({"resume": letter * 32} for letter in "abcde"),
    )

    def admits(client_id: int, query: dict[str, str], at: float) -> bool:
        nonlocal now
        now = at
        return lead.admits(client_id, query)

    assert not admits(1, ann | {"screen": "1"}, 0.0)
    assert admits(2, ann, 0.0) and not admits(3, bo, 1.0) and lead.holds(2) and not lead.holds(3)
    # A reload: the new connection is there before the old one has gone.
    assert admits(4, ann, 10.0)
    lead.gone(2)
    assert lead.holds(4) and not admits(5, others[0], 80.0)
    now = 100.0
    lead.gone(4)
    assert not admits(6, bo, 101.0) and not admits(7, others[1], 159.0)
    # After the minute those who were in the class, or have no id, come back as students; a new tab leads.
    assert not any(admits(8, one, 161.0) for one in (bo, *others, {}))
    assert admits(9, cy, 162.0) and not admits(10, ann, 163.0)


def test_one_wrong_key_a_second_is_answered_from_one_address_and_the_right_one_never_waits() -> None:
    now, wrong, right = 0.0, {"key": "chalk"}, {"key": "chalk-dust"}
    guesses, keyless = (Guesses(key, lambda: now) for key in ("chalk-dust", None))
    for now, address, query, delay in (  # noqa: B007  the clock reads it
        (5.0, "here", wrong, 1.0),
        (5.0, "here", wrong, 2.0),
        (5.5, "here", right, 0.0),
        (5.5, "here", {}, 0.0),
        (5.5, "here", wrong, 2.5),
        (5.5, "there", wrong, 1.0),
        (60.0, "here", wrong, 1.0),
    ):
        assert guesses.delay(address, query) == pytest.approx(delay)
        assert keyless.delay(address, query) == 0.0
    assert max(guesses.delay("here", wrong) for _ in range(100)) == LONGEST
    for i in range(MOST_ADDRESSES + 5):
        guesses.delay(f"{i}", wrong)
    assert len(guesses._wrong) == MOST_ADDRESSES


def test_the_teacher_enters_while_a_student_with_the_same_address_guesses(
    house: OpenHouse, join: Join
) -> None:
    opened = house(lecture=True, key="chalk-dust")
    done = threading.Event()

    def guess() -> None:
        while not done.is_set():
            BlockingClient(opened.url, query="key=chalk-guess").close()

    guessers = [threading.Thread(target=guess) for _ in range(4)]
    for one in guessers:
        one.start()
    try:
        until(lambda: opened.server._delayed == 4)
        teacher = join(opened, f"{LEADER}&key=chalk-dust")
        teacher.wait_for(lambda v: LINK in v.mirror.grabbable)
        assert lecture_of(opened).controls.operator is not None
    finally:
        done.set()
        for one in guessers:
            one.join()


BOOK = our_book()
LESSON = next(i for i, lesson in enumerate(BOOK.lessons) if lesson.number == 1)


def strokes(visitor: Client) -> set[tuple[str, float]]:
    plots = bodies(visitor, "GuiUplotMessage")
    return {(str(line["stroke"]), float(line["width"])) for plot in plots for line in plot["series"][1:]}


@pytest.mark.thorough
def test_every_tab_has_its_own_look_and_language_and_what_a_look_shows_is_packed_once(
    house: OpenHouse, join: Join
) -> None:
    opened = house(lecture=True)
    host = lecture_of(opened)
    teacher = join(opened, f"resume={'1' * 32}", headers={"Accept-Language": "en"})
    teacher.wait_for(lambda v: v.mirror.grabbable, WAIT)
    english, german = join(opened, headers={"Accept-Language": "en"}), join(opened, "lang=de&picture=fast")
    screen = join(opened, "screen=1&profile=projector&theme=dark&lang=de")
    slovene = join(opened, headers={"Accept-Language": "sl, de;q=0.5"})
    ask(host.session, lambda _: host.lessons.enter(BOOK.lessons[LESSON].id))
    looks: list[tuple[BlockingClient, Language]] = [
        (english, "en"),
        (german, "de"),
        (screen, "de"),
        (slovene, "sl"),
    ]
    for visitor, language in looks:
        step = BOOK.in_language(language).lessons[LESSON].steps[0]
        theme, larger = ("dark", 1.3) if visitor is screen else ("light", 1.0)
        sees(visitor, plain(step.title), words_of(language)("Goal"), f"--duet-k:{larger:g}")
        visitor.wait_for(
            lambda v, theme=theme: PALETTES[theme].error in {colour for colour, _ in strokes(v)}, WAIT
        )
        assert 2.2 * larger in {width for _, width in strokes(visitor)}
        lit = visitor is german
        visitor.wait_for(
            lambda v, lit=lit: bool(v.mirror.nodes.get("/light/sky", {}).get("visible", True)) == lit, WAIT
        )
        if visitor is not screen:
            # The palette's names and the buttons of the answers are in the language of the tab too.
            assert step.question is not None
            name, answer = (
                words_of(language)("Answer {number}", number=1),
                f"1   {plain(step.question.choices[0].text)}",
            )
            visitor.wait_for(
                lambda v, name=name: name in {c["label"] for c in list(v.mirror.commands.values())}, WAIT
            )
            visitor.wait_for(lambda v, answer=answer: answer in buttons(v), WAIT)
    assert not screen.mirror.commands
    # What the teacher chooses for the own page stays there, and the lesson goes on where it is.
    steps = ask(host.session, lambda _: host.lessons.walk.run_id)
    ask(
        host.session,
        lambda s: [s.change("lang", "sl"), s.change("theme", "dark"), s.change("profile", "projector")],
    )
    sees(teacher, plain(BOOK.in_language("sl").lessons[LESSON].steps[0].title), "--duet-k:1.3")
    teacher.wait_for(lambda v: PALETTES["dark"].error in {colour for colour, _ in strokes(v)}, WAIT)
    assert (
        "--duet-k:1.3" not in shown(english)
        and ask(host.session, lambda _: host.lessons.walk.run_id) == steps
    )
    sees(english, plain(BOOK.lessons[LESSON].steps[0].title))
    # The class's answers and the outcome, in every language.
    click(german, "1   ")
    walk = host.lessons.walk
    place = walk.lesson.id, walk.step.id
    teacher.wait_for(lambda _: host.classroom.ballots.counts(place, 3, ()).newest.answered == 1, WAIT)
    host.control.post("reveal")
    ask(host.session, lambda _: host.lessons.act(Press("next")))
    for visitor, language in looks:
        sees(visitor, words_of(language)("The class said"), words_of(language)("Measured"))
    # What a look shows is packed once, and forgotten with its last watcher.
    bo = join(opened, "lang=de&picture=fast&dm=0.3")
    assert sorted(len(audience.watchers) for audience in host.audiences.audiences) == [1, 1, 1, 2]
    german.close()
    bo.wait_for(lambda _: [len(one.watchers) for one in host.audiences.audiences] == [1, 1, 1, 1], WAIT)
    for one in (english, screen):
        one.close()
    bo.wait_for(lambda _: len(host.shared.pages) == 2, WAIT)
    # Only this number of looks is drawn; more of them join the one that is most like theirs, in their language.
    every = itertools.product(("sl", "en"), ("light", "dark"), ("desk", "projector"))
    more = [f"lang={lang}&theme={theme}&profile={size}" for lang, theme, size in every]
    # Each is a tab of its own, as without an id one address has few connections.
    others = [join(opened, f"{look}&resume={number:016d}") for number, look in enumerate(more)]
    assert len(host.audiences.audiences) == MOST and len(more) + 1 > MOST
    last = join(opened, f"lang=de&theme=dark&picture=fast&resume={'f' * 16}")
    sees(last, 'data-words="de"')
    assert len(host.audiences.audiences) == MOST and all(one.closed is None for one in others)
    # A place is taken, and given back, a moment later.
    last.wait_for(lambda _: opened.server.count_clients() == 12, WAIT)


def test_a_students_page_that_fails_is_logged_and_costs_no_other_one_its_frame(
    by_hand: Made, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    opened = by_hand(lecture=True, key="chalk", sessions=8)
    for name in ("ann", "bo"):
        opened.let_in(f"resume={tab_of(name)}")
    ann, bo = lecture_of(opened).participants.values()
    drawn: list[Any] = []

    def fail(*_: Any) -> None:
        raise RuntimeError("the banner")

    monkeypatch.setattr(ann, "show", fail)
    monkeypatch.setattr(bo, "show", lambda *given: drawn.append(given))
    opened.frame()
    assert len(drawn) == 1 and "a frame of a student's page failed" in caplog.text
