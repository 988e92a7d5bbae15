"""Every action has one handler, or two that are asked in order: the tables for each surface."""

import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import numpy as np

from app.features.jupyter.notebook_run import NotebookRun
from app.features.lecture.lecture_options import LectureOptions
from app.features.lessons.session.lesson_actions import Write
from app.features.second_person.guest import Guest, place_of
from app.session.action_handlers import ActionHandlers, Handler
from app.session.actions import Action, Drag, Nudge, Pause, Reset, SetSetting, SingleStep
from app.settings import JOIN, Settings
from scenes.settings import RunSettings
from tests.app.conftest import Made, visitor_of
from tests.app.features.custom_law.helpers import edited
from tests.app.features.lecture.lecture_room import lecture_of
from tests.app.features.lessons.helpers import lessons_of
from tests.app.inline import Inline
from tests.app.recording.runs import piece

SESSION = {
    "Pause": ("ReplayPlayer", "Session"),
    "SingleStep": ("ReplayPlayer", "Session"),
    "Reset": ("ReplayPlayer", "Session"),
    "ChangeSpeed": ("Session",),
    "SetSetting": ("Session",),
    "Digit": ("Session",),
    "RestoreSettings": ("Session",),
    "MoveJoint": ("Session",),
}
"""Actions without a page."""

LESSON_ACTIONS = ("Enter", "Choose", "Draw", "Guess", "GoTo", "SayNumber", "Write", "GiveReason", "Press")

PAGE = SESSION | {
    "Pause": ("ReplayPlayer", "LessonControls"),
    "SingleStep": ("ReplayPlayer", "LessonControls"),
    "Reset": ("ReplayPlayer", "LessonControls"),
    "Nudge": ("LeverPanel", "LessonControls"),
    "Digit": ("LessonControls", "Operation"),
    "Toggle": ("LessonControls", "Operation"),
    "SetSetting": ("Operation",),
    "ShowAll": ("Operation",),
    "MoreLaws": ("Controls",),
    "MorePlots": ("DetailsChooser",),
    "TickLaw": ("LawTicks",),
    "FirstView": ("Operation",),
    "Compute": ("ComparePanel",),
    "Drag": ("Gizmos",),
    "Hover": ("Gizmos",),
    "SwingElbow": ("Gizmos",),
    "Describe": ("SceneWords",),
    "OperateReplay": ("ReplayBar",),
    "SeekReplay": ("Scrubber",),
    "ChooseLength": ("ReplayBar",),
    "Export": ("ExportsPanel",),
    "LoadRun": ("ExportsPanel",),
    "Magnify": ("MicroscopeButtons",),
    "SeekInstant": ("Scrubber",),
    "ShowMoment": ("MicroscopeButtons", "MomentChooser"),
    "TakePerson": ("SourceChooser",),
    "AskReport": ("LabReportBox",),
    "AskPushFilm": ("DuelBox",),
    "AskToLeave": ("LessonControls",),
    "TakeDrawing": ("Controls",),
    "MoveInNullSpace": ("NullMotionSliders",),
    **dict.fromkeys(LESSON_ACTIONS, ("LessonControls",)),
}
"""Actions of a page on which a lesson was opened."""

OWNER = PAGE | {"Invite": ("InviteBox",), "RunLaw": ("LawEditor",)}
"""Actions of the page of the server's owner."""

FORMULA = {"RunLaw": ("LawEditor",), "StopFormula": ("FormulaEditor",)}
"""Differences on a page where a law is written as a formula, not in a file."""

LECTURE_ONLY = {"Teach": ("TeacherControl",)}

LECTURE = SESSION | LECTURE_ONLY
"""Actions of a lecture's shared session without a teacher."""

TEACHER = PAGE | FORMULA | LECTURE_ONLY | {"MakeReport": ("ClassDownloads",)}

STUDENTS = {
    "Answer": ("TeacherControl",),
    "Because": ("TeacherControl",),
    "TakeDrawing": ("TeacherControl",),
    "Progressed": ("TeacherControl",),
    "Ran": ("TeacherControl",),
    "Reported": ("TeacherControl",),
}
"""Actions that students send to the shared session."""

SECOND_PERSON = {
    "Drag": ("Gizmos",),
    "Hover": ("Gizmos",),
    "SwingElbow": ("Gizmos",),
    "Nudge": ("Gizmos",),
    "Describe": ("SceneWords",),
    "FirstView": ("Guest",),
}

NOTEBOOK = LECTURE | {"Ask": ("NotebookRun",)}


def kinds(of: type[Action] = Action) -> Iterator[type[Action]]:
    """All types of actions in the product, without base classes."""
    further = [one for one in of.__subclasses__() if one.__module__.startswith("app.")]
    if not further:
        yield of
    for one in further:
        yield from kinds(one)


def table(handlers: ActionHandlers) -> dict[str, tuple[str, ...]]:
    """Names of actions with the classes of their handlers in order."""
    found = {kind.__name__: tuple(owner(one) for one in handlers.of(kind)) for kind in kinds()}
    return {name: owners for name, owners in found.items() if owners}


def owner(handler: Handler) -> str:
    name = getattr(handler, "__qualname__", "")
    assert isinstance(name, str) and name
    return name.partition(".")[0]


def code_of(handler: Any) -> CodeType:
    return getattr(handler, "__func__", handler).__code__


def asked(handlers: ActionHandlers, action: Action) -> list[str]:
    """Names of the registered handlers that run during an action."""
    known = {code_of(one): one for kind in kinds() for one in handlers.of(kind)}
    seen: list[str] = []

    def note(frame: FrameType, event: str, argument: object) -> None:
        del argument
        if event == "call" and frame.f_code in known:
            seen.append(known[frame.f_code].__qualname__)

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        handlers.do(action)
    finally:
        sys.setprofile(before)
    return seen


def test_every_action_has_one_handler_or_two(by_hand: Made, tmp_path: Path) -> None:
    home = by_hand(settings=Settings(run=RunSettings(scene="hold")), features=(edited(tmp_path / "law.py"),))
    home.let_in(f"resume={1:032d}")
    visitor = visitor_of(home)
    assert table(visitor.session.handlers) == {
        name: owners for name, owners in OWNER.items() if name != "MoveInNullSpace"
    }
    # The sliders of the null space are created when the first lesson is opened.
    lessons_of(visitor).enter(0)
    home.frame()
    assert table(visitor.session.handlers) == OWNER
    place_of(visitor).word = "word"
    home.let_in(f"{JOIN}=word&resume={2:032d}")
    (guest,) = visitor.beside
    assert isinstance(guest, Guest) and table(guest._handlers) == SECOND_PERSON

    school = by_hand(features=(LectureOptions(lecture=True),), key="chalk")
    lecture = lecture_of(school)
    assert table(lecture.session.handlers) == LECTURE
    school.let_in("key=chalk")
    lecture.lessons.enter(0)
    school.frame()
    assert table(lecture.session.handlers) == TEACHER and table(lecture.control._of_students) == STUDENTS

    with closing(NotebookRun(Settings())) as run:
        assert table(run._session.handlers) == NOTEBOOK

    everywhere = (OWNER, TEACHER, STUDENTS, SECOND_PERSON, NOTEBOOK)
    assert {name for one in everywhere for name in one} == {kind.__name__ for kind in kinds()}
    assert all(1 <= len(owners) <= 2 for one in everywhere for owners in one.values())


def test_a_drag_reaches_one_handler(by_hand: Made) -> None:
    home = by_hand()
    home.let_in()
    handlers = visitor_of(home).session.handlers
    assert asked(handlers, Drag("/none", "update", np.zeros(3))) == ["Gizmos._drag"]
    assert asked(handlers, Write("", "", "")) == ["LessonControls._act"]
    assert asked(handlers, Pause()) == ["ReplayPlayer.pause", "LessonControls._pause"]
    assert asked(handlers, Nudge(up=1)) == ["LeverPanel._move", "LessonControls._nudge"]
    (change,) = asked(handlers, SetSetting("dm", 0.2))
    assert change.startswith("Operation.")


def test_in_a_replay_keys_control_the_replay_then_the_lesson_then_the_run(by_hand: Made) -> None:
    pool = Inline()
    home = by_hand(jobs=pool)
    home.let_in("lesson=1")
    visitor = visitor_of(home)
    session, lessons, player = visitor.session, lessons_of(visitor), visitor.session.player
    do, begun = session.handlers.do, lessons.walk.run_id
    assert lessons.open and lessons.locked
    player.watch_file(piece("ball", 1.0)[0], "theirs.duet.npz")
    for action in (Pause(), SingleStep()):
        # The keys wait for a loading run.
        do(action)
        assert player.coming and not session.notices
    assert pool.work("film")
    home.frame()
    assert player.replay is not None and player.replay.playing
    do(Pause())
    assert not player.replay.playing and not session.notices
    step = player.replay.step
    do(SingleStep())
    assert player.replay.step == step + 1 and not session.notices
    do(Reset())
    assert player.replay is None and lessons.walk.run_id == begun
    for action in (Pause(), SingleStep()):
        do(action)
        assert session.notices.pop()[0] == "Predict first" and not session.simulation.steps
    do(Reset())
    assert lessons.walk.run_id > begun
    lessons.leave()
    for paused in (not session.paused, session.paused):
        do(Pause())
        assert session.paused == paused


def test_another_language_gets_new_handlers_and_the_old_page_may_close_late(
    by_hand: Made,
) -> None:
    home = by_hand()
    client = home.let_in()
    visitor = visitor_of(home)
    handlers, old, before = visitor.session.handlers, visitor.operation, visitor.session.handlers.of(Drag)
    visitor.session.change("lang", "de")
    home.frame()
    new = handlers.of(Drag)
    assert visitor.operation is not old and len(new) == 1 and new != before
    old.close()
    assert handlers.of(Drag) == new
    home.leave(client)
    home.frame()
    assert table(handlers) == SESSION
