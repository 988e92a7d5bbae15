"""The lessons on the page, on the server's side: links, choices, runs, verdicts, challenges, and that nothing is stuck or lost."""

import re
from pathlib import Path

import pytest

from app.bench.blocking_client import BlockingClient
from app.classroom.lecture import LectureHost
from app.hosting.private_host import PrivateHost
from app.hosting.resume import open_link
from app.lessons import FOLDER
from app.lessons.loading import LANGUAGES, Language, load_lessons
from app.lessons.phases import Phase
from app.lessons.reference_runs import person_of
from app.lessons.session.lesson_actions import (
    Check,
    Choose,
    GoBack,
    GoOn,
    GoTo,
    Leave,
    ResetStep,
    RunAgain,
    ShowHint,
    ShowWhy,
    StartOrPause,
)
from app.lessons.session.lesson_session import LessonSession
from app.lessons.walkthrough import Walkthrough
from app.page.lessons.elbow_marks import reaches
from app.page.lessons.forecast_boxes import read_number
from app.page.lessons.lesson_html import blocks_html
from app.page.panels.hotkeys import HOTKEYS, LESSON_KEYS
from app.session.session import Session
from app.settings import Settings
from app.start import App
from app.text.formula import formula, plain_formula
from app.text.lesson_text import lesson_html, plain
from app.text.picture import PICTURE, read_picture
from scenes.roles import NoSource
from scenes.settings import changed, values
from tests.app.conftest import Arrive, Guest, Join, OpenHouse, ask, live_sessions

BOOK = load_lessons()
WORD = "0123456789abcdef0123456789abcdef"


def run_of(house: App, guest: Guest) -> LessonSession:
    """The lessons of a visitor."""
    assert isinstance(house.host, PrivateHost)
    return house.host.visitors[guest.number].lessons


def as_opened(settings: Settings) -> Settings:
    """Settings as a link would give them: the language is the browser's."""
    return changed(settings, "lang", "auto")


def labels(visitor: BlockingClient) -> list[str]:
    """What stands on the buttons in view."""
    found = [e for e in list(visitor.mirror.gui.values()) if e["type"] == "GuiButtonMessage" and e.get("visible", True)]
    return [str(e["label"]) for e in found]


def click(visitor: BlockingClient, start: str) -> None:
    """Press the button in view whose label begins like this."""
    visitor.wait_for(lambda v: any(label.startswith(start) for label in labels(visitor)))
    visitor.click(next(label for label in labels(visitor) if label.startswith(start)))


def alone(lesson: int = 0, step: int = 0) -> tuple[Session, LessonSession]:
    """A session without a page, in a lesson."""
    session = Session(Settings())
    run = LessonSession(session, BOOK)
    run.enter(lesson, step)
    return session, run


def play(session: Session, run: LessonSession, frames: int = 4000) -> None:
    """Draw frames, without waiting, until the run stands still."""
    run._runs.wait(60.0)
    for _ in range(frames):
        session.advance(0.05)
        run.decide()
        if session.paused and not run.computing and (run._runs.ready or session.simulation.steps == 0):
            return
    raise AssertionError("the run does not end")


def finish(session: Session, run: LessonSession) -> None:
    """Run to the end, and measure."""
    run.act(StartOrPause())
    play(session, run)
    run.decide()


def to_challenge(session: Session, run: LessonSession) -> None:
    """Go on to the step's challenge, and skip what can be skipped."""
    while run.walk.phase is not Phase.CHALLENGE:
        run.act(GoOn())
        session.advance(0.0)
        run.decide()


def test_a_run_is_locked_until_an_answer_is_chosen() -> None:
    session, run = alone()
    for action in (StartOrPause(), GoOn(), ShowWhy(), Check()):
        run.act(action)
        session.advance(0.1)
        run.decide()
        assert session.paused and session.simulation.steps == 0 and run.walk.phase is Phase.PREDICT, action
    session.toggle_pause()
    run.decide()
    assert session.paused
    run.act(Choose(0))
    assert run.walk.phase is Phase.DO
    run.act(StartOrPause())
    session.advance(0.1)
    assert session.simulation.steps > 0


def test_the_outcome_is_measured_in_this_run_and_a_wrong_choice_gets_its_own() -> None:
    session, run = alone()
    run.act(Choose(1))
    finish(session, run)
    verdict = run.view().verdict
    assert run.walk.phase is Phase.OBSERVE and verdict is not None and not verdict.right and session.paused
    assert run.view().verdict is not None and not run.walk.done.outcome.reference  # type: ignore[union-attr]
    run.act(ShowWhy())
    assert run.view().showing and session.simulation.steps == 0
    finish(session, run)
    assert run.view().why_outcome
    run.act(GoOn())
    assert not run.view().showing


def test_a_run_that_is_skipped_is_still_measured() -> None:
    session, run = alone()
    run.act(Choose(1))
    run._runs.wait(60.0)
    run.act(GoOn())
    assert run.walk.phase is Phase.DO
    while run.walk.phase is Phase.DO:
        before = session.simulation.steps
        session.advance(0.0)
        run.decide()
        assert session.simulation.steps > before, "it hurries, whatever the clock on the wall says"
    outcome = run.walk.done.outcome
    assert run.walk.phase is Phase.OBSERVE and outcome is not None and outcome.complete and not outcome.reference
    assert session.paused and run.walk.finished(session.simulation)


def test_a_run_that_cannot_go_on_is_skipped_all_the_same() -> None:
    session, run = alone()
    run.act(Choose(1))
    run._runs.wait(60.0)
    session.halt.set("teacher")
    run.act(GoOn())
    outcome = run.walk.done.outcome
    assert run.walk.phase is Phase.OBSERVE and outcome is not None and outcome.reference


def test_leaving_gives_the_visitors_own_settings_back() -> None:
    session = Session(changed(changed(Settings(), "dm", 0.11), "autopilot", False))
    before = session.settings
    run = LessonSession(session, BOOK)
    for lesson in range(len(BOOK.lessons)):
        run.enter(lesson)
        session.advance(0.05)
        run.decide()
        assert values(session.settings)["scene"] == BOOK.lessons[lesson].steps[0].setup.run.scene
    session.change("theme", "dark")
    run.act(Leave())
    assert session.settings == changed(before, "theme", "dark") and not session.paused and not run.open
    assert session.target() is None


def test_reset_is_a_fresh_start_and_back_and_next_always_work() -> None:
    session, run = alone()
    fresh = run.walk.to_json(), values(session.settings)
    run.act(Choose(2))
    session.change("k", 9.0)
    run.act(ResetStep())
    assert (run.walk.to_json(), values(session.settings)) == fresh
    run.act(GoBack())
    assert run.walk.phase is Phase.PREDICT


def test_another_experiment_in_the_middle_of_a_lesson_begins_the_run_anew() -> None:
    session, run = alone()
    run.act(Choose(2))
    session.change("scene", "hold")
    run.decide()
    assert session.settings.run.scene == "solo" and run.notes
    session.change("autopilot", False)
    run.decide()
    assert session.settings.page.autopilot


def test_nonsense_does_no_harm() -> None:
    session, run = alone()
    for action in (GoTo(99, 0), GoTo(0, 99), Choose(-1), Choose(99), ShowWhy(), Check()):
        run.act(action)
        run.decide()
        session.advance(0.05)
    assert run.open and run.walk.phase is Phase.PREDICT


def test_a_challenge_says_what_failed() -> None:
    session, run = alone(0, 2)
    to_challenge(session, run)
    assert run.walk.yours and not run.hands_off and not session.paused
    for _ in range(40):
        session.advance(0.05)
        run.decide()
    run.act(Check())
    attempt = run.view().attempt
    assert attempt is not None and not attempt.passed and attempt.failed
    assert any("must be" in j.text for j in attempt.judgements)
    run.act(ShowHint())
    assert len(run.view().hints) == 1


def swing(session: Session, run: LessonSession) -> None:
    """Swing the elbow as a drag would, mark to mark, until the present run is long enough."""
    trial = next(trial for trial in run.walk.step.trials if not trial.fails)
    person = person_of(session.simulation, trial.setup)
    while session.simulation.time < trial.setup.seconds:
        session.hold(person.target(session.simulation.time))
        session.advance(0.02)
        run.decide()


def test_a_challenge_is_tried_again_with_the_students_own_settings() -> None:
    session, run = alone(0, 2)
    to_challenge(session, run)
    session.advance(0.05)
    run.decide()
    session.change("k", 5.0)
    session.change("dt", 0.005)
    swing(session, run)
    run.act(Check())
    attempt = run.view().attempt
    assert attempt is not None and not attempt.passed and attempt.note, "settings changed in the middle of the run"
    run.act(RunAgain())
    assert session.simulation.steps == 0 and session.settings.run.gain == 5.0 and not session.paused
    swing(session, run)
    run.act(Check())
    assert run.walk.done.passed, run.view().attempt
    run.act(ResetStep())
    run.act(GoOn())
    assert session.settings.run.gain == run.walk.setup.run.gain != 5.0


def test_marks_are_touched_as_near_as_the_challenge_asks() -> None:
    step = BOOK.lessons[0].steps[2]
    assert reaches(step) == (0.015, 0.015) and len(step.marks) == 2
    assert reaches(BOOK.lessons[0].steps[0]) == ()


def test_what_a_student_changed_pushed_and_typed_is_taken_up_again() -> None:
    session, run = alone(2, 2)
    to_challenge(session, run)
    session.change("v", 0.17)
    run.said.extend([0.25, None, 0.5])
    run.walk._kept["push"] = NoSource()
    saved = run.saved()
    assert saved is not None
    other = Session(Settings())
    again = LessonSession(other, BOOK)
    again.resume(saved, reopen=True)
    assert other.settings.run == session.settings.run and other.settings.run.law.nominal_velocity == 0.17
    assert again.said == [0.25, None, 0.5] and dict(again.walk.kept) == dict(run.walk.kept)
    again.act(Leave())
    assert other.settings == Settings()
    again.enter(2, 2)
    again.act(ResetStep())
    assert again.said == []


def test_no_text_of_a_file_reaches_the_page_as_html_of_its_own() -> None:
    made = lesson_html("a <script>alert(1)</script> *b <i>c</i>* `<d>` $x<y$\n\n- <e>\n\n![<f>](g.svg)", Path("/nowhere"))
    for bad in ("<script", "<i>", "<d>", "<e>", "<f>"):
        assert bad not in made
    assert "<em>b" in made and "<svg" in made


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_picture_of_our_lessons_is_drawn_and_none_is_shown_as_it_is_written(language: Language) -> None:
    """Every part of every step, as a student walks it."""
    book = load_lessons(language=language)
    walk, shown = Walkthrough(book), list[str]()
    while True:
        shown += blocks_html(walk.view(), (), False, False).values()
        question = walk.step.question
        if question is not None and walk.locked:
            walk.choose(question.right)
        while walk.hint():
            pass
        shown += blocks_html(walk.view(), (), False, False).values()
        if not walk.next():
            break
    made = "".join(shown)
    assert "![" not in made
    named = {
        name for lesson in book.lessons for step in lesson.steps for _, name in PICTURE.findall(f"{step.observe}\n{step.explain}")
    }
    assert {name.removesuffix(".svg").removesuffix(f".{language}") for name in named} == {
        f"pictures/{name}" for name in ("elbow", "jump", "line", "lever", "kinks")
    }
    for name in named:
        picture = read_picture(FOLDER, name).svg
        assert 'class="d' in picture and "currentColor" in picture and picture.removeprefix("<svg ") in made


def test_an_svg_that_holds_more_than_shapes_stays_a_picture_of_its_own(tmp_path: Path) -> None:
    head = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1 1"'
    for i, text in enumerate(
        (
            f"{head}><script>alert(1)</script></svg>",
            f'{head} onload="alert(1)"/>',
            f'{head}><g><path d="M0 0" onclick="alert(1)"/></g></svg>',
            f'{head}><foreignObject><p xmlns="http://www.w3.org/1999/xhtml">x</p></foreignObject></svg>',
            f'{head}><path style="fill:red" d="M0 0"/></svg>',
            f'{head}><path fill="url(https://example.org/x)" d="M0 0"/></svg>',
            f'{head}><path id="duet-say" d="M0 0"/></svg>',
            f'{head} xmlns:xlink="http://www.w3.org/1999/xlink"><image xlink:href="https://example.org/x"/></svg>',
        )
    ):
        (tmp_path / f"{i}.svg").write_text(text, encoding="utf-8")
        made = lesson_html(f'![a "b" <c>]({i}.svg)', tmp_path)
        assert re.fullmatch(r'<img alt="a &quot;b&quot; &lt;c&gt;" src="data:image/svg\+xml;base64,[\w+/=]+">', made)
    (tmp_path / "plain.svg").write_text(f"{head}><title>x</title><text>&lt;b&gt;</text></svg>", encoding="utf-8")
    made = lesson_html('![a "b"](plain.svg)', tmp_path)
    assert made == '<svg class="picture" role="img" aria-label="a &quot;b&quot;" viewBox="0 0 1 1"><text>&lt;b&gt;</text></svg>'


def test_every_formula_of_our_lessons_is_drawn() -> None:
    for lesson in BOOK.lessons:
        for step in lesson.steps:
            parts = [step.goal, step.do, step.observe, step.explain]
            if step.question is not None:
                parts += [step.question.text, *(c.text for c in step.question.choices), *(c.reply for c in step.question.choices)]
            made = lesson_html("\n\n".join(parts))
            assert "$" not in made and "\\" not in made.replace("\\n", ""), (lesson.id, step.id)
            assert made.count("<svg") >= "\n\n".join(parts).count("$$") // 2


def test_symbols_have_their_colours_and_a_name() -> None:
    made = formula(r"\dot d = \lambda v - (1 - \lambda) u - w", True)
    for name in ("lam", "v", "u", "w"):
        assert f'class="{name}"' in made
    assert 'role="img"' in made and "λ" in made and "λ" in plain_formula(r"\lambda")
    assert plain("*half* of $d_m$, **not** `all`") == "half of dₘ, not all"


@pytest.mark.parametrize(
    ("text", "number"), [("0.5", 0.5), ("0,5 rad/s", 0.5), ("−2", -2.0), ("", None), ("x", None), ("nan", None), ("1e99", None)]
)
def test_a_number_is_read_as_a_person_types_it(text: str, number: float | None) -> None:
    assert read_number(text) == number


def test_keys_are_told_once() -> None:
    keys = [(h.key, h.modifier) for h in (*HOTKEYS, *LESSON_KEYS)]
    assert len(set(keys)) == len(keys) and len({h.text for h in (*HOTKEYS, *LESSON_KEYS)}) == len(keys)


def test_without_a_link_the_page_is_as_ever(house: OpenHouse, arrive: Arrive) -> None:
    opened = house()
    guest = arrive(opened)
    assert not run_of(opened, guest).open and "Lessons" in labels(guest.visitor)
    assert as_opened(guest.session.settings) == Settings()


def test_a_link_opens_a_step_and_buttons_walk_it(house: OpenHouse, request: pytest.FixtureRequest) -> None:
    opened = house()
    visitor = BlockingClient(opened.url, query=f"lesson=3&step=2&resume={WORD}")
    with visitor:
        visitor.wait_for(lambda v: len(v.mirror.commands) == len(HOTKEYS) + len(LESSON_KEYS))
        (number,) = live_sessions(opened)
        assert isinstance(opened.host, PrivateHost)
        run, session = opened.host.visitors[number].lessons, live_sessions(opened)[number]
        assert (run.walk.lesson.id, run.walk._at.step_index) == ("strict-priority", 1)
        # A lesson shows the plots that its step needs, and offers no others.
        visitor.wait_for(lambda v: not v.mirror.labelled("more plots")["visible"])
        visitor.wait_for(lambda _: "Run (predict first)" in labels(visitor))
        click(visitor, "2 ")
        visitor.wait_for(lambda _: "Run" in labels(visitor))
        ask(session, lambda s: s.change("speed", 2.0))
        click(visitor, "Run")
        visitor.wait_for(lambda _: run.walk.phase is Phase.OBSERVE, 60.0)
        visitor.wait_for(lambda _: "Next: explain" in labels(visitor))
        kept = ask(session, lambda _: run.walk.to_json())
    # The connection is lost; the same tab comes back by the same link.
    visitor = BlockingClient(opened.url, query=f"lesson=3&step=2&resume={WORD}")
    request.addfinalizer(visitor.close)
    visitor.wait_for(lambda v: len(v.mirror.commands) == len(HOTKEYS) + len(LESSON_KEYS))
    number = max(live_sessions(opened))
    again = opened.host.visitors[number].lessons
    assert again.open and again.walk.to_json() == kept
    click(visitor, "Leave")
    visitor.wait_for(lambda _: not again.open)
    visitor.wait_for(lambda v: v.mirror.labelled("more plots")["visible"])
    assert as_opened(live_sessions(opened)[number].settings) == Settings()


def test_a_bad_link_is_named_and_the_page_goes_on(house: OpenHouse, arrive: Arrive) -> None:
    opened = house()
    for query in ("lesson=99", "lesson=%3Cb%3E", "step=2"):
        guest = arrive(opened, query)
        assert not run_of(opened, guest).open
        guest.run_on(0.1)
        guest.visitor.close()
    run = LessonSession(Session(Settings()), BOOK)
    assert "choose from 1" in open_link(run, {"lesson": "99"}, None)[0] and not run.open
    assert open_link(run, {"lesson": "1", "step": "x"}, None) and run.open and run.walk.lesson is BOOK.lessons[0]
    assert open_link(run, {"lesson": "strict-priority", "step": "2"}, None) == () and run.walk.step.id == "switch"
    open_link(run, {"lesson": "1", "step": "77"}, None)
    assert run.notes


def test_broken_files_are_named_and_the_others_load(house: OpenHouse, arrive: Arrive, tmp_path: Path) -> None:
    (tmp_path / "01-good.md").write_text(
        '# Good\n\nGoal.\n\n## One\n\n```duet\nsettings = { scene = "solo" }\n```\n\n### Goal\n\nG.\n\n### Do\n\nD.\n',
        encoding="utf-8",
    )
    (tmp_path / "02-bad.md").write_text("# Bad\n", encoding="utf-8")
    opened = house(lessons=tmp_path)
    guest = arrive(opened)
    run = run_of(opened, guest)
    ask(guest.session, lambda _: run.enter(0))
    assert run.open and len(run.book.lessons) == 1 and "02-bad.md" in str(run.book.problems[0])


def test_a_lecture_shows_the_lesson_to_all_and_gives_the_buttons_to_one(
    house: OpenHouse, join: Join, request: pytest.FixtureRequest
) -> None:
    opened = house(lecture=True)
    first = join(opened)
    click(first, "Lessons")
    first.wait_for(lambda _: "Run (predict first)" in labels(first))
    second = BlockingClient(opened.url)
    request.addfinalizer(second.close)
    second.wait_for(lambda v: any("What is left over" in str(e.get("content")) for e in list(v.mirror.gui.values())))
    assert not any(label.startswith("Run") for label in labels(second))
    assert isinstance(opened.host, LectureHost) and opened.host.lessons.open
