"""How a session begins a lesson's run, takes on its settings, and gets the visitor's own ones back."""

from dataclasses import replace

from app.i18n.speaking import N_
from app.lessons.phases import Phase
from app.lessons.reference_runs import begin as begin_run
from app.lessons.reference_runs import person_of
from app.lessons.walkthrough import Walkthrough
from app.session.session import Session
from app.settings import Look, Settings
from controllers.errors import BadSetting
from scenes.settings import values
from scenes.simulation import Simulation


def with_look(settings: Settings, session: Session) -> Settings:
    """Return settings with the look that the page has now: a lesson does not change how the visitor likes to see it."""
    page = session.settings.page
    look = Look(page.theme, page.profile, page.picture, page.language)
    return replace(settings, page=replace(look.of(settings.page), gizmo=page.gizmo))


def apply_settings(session: Session, settings: Settings) -> str:
    """Apply settings one by one, in whatever order they are possible; return the last refusal, "" if all were applied."""
    problem = ""
    for _ in range(3):
        problem = ""
        for key, value in values(settings).items():
            if values(session.settings)[key] != value:
                try:
                    session.change(key, value)
                except BadSetting as error:
                    problem = str(error)
        if not problem:
            break
    return problem


def asks_for_custom_law(walk: Walkthrough) -> bool:
    """Return whether it is the turn of the visitor's own law: everything else in the lessons is about the settings' law."""
    challenge = walk.step.challenge
    return walk.phase is Phase.CHALLENGE and challenge is not None and challenge.custom_law


def begin(session: Session, walk: Walkthrough) -> None:
    """Begin the present run of a walkthrough in a session that has its settings: from its start, with its target source."""
    session.let_custom_law_run(asks_for_custom_law(walk))
    session.reset()
    start = walk.start(session.simulation)
    if start is not None:
        session.simulation.reset(start)
        if session.ghost is not None:
            session.ghost.reset(start)
    if walk.yours:
        session.set_source(None)
        session.change("autopilot", False)
    else:
        session.set_source(walk.target_source(session.simulation))
    if walk.showing:
        asked = walk.step.setup
        beside = Simulation(asked.run)
        begin_run(beside, asked)
        session.show_beside(beside, person_of(beside, asked, walk.kept))
    # A hand that is the visitor's answers at once; anything else waits for Run.
    session.halt.go_on()
    session.halt.set("lesson", walk.locked or not walk.yours)


def deviation_from_lesson(session: Session, walk: Walkthrough) -> tuple[str, str] | None:
    """Return title and text of a notice if the visitor has chosen what the lesson's run cannot go on with; None if it can."""
    asked, has = walk.setup.run, session.settings.run
    if (asked.scene, asked.rig, asked.robot) != (has.scene, has.rig, has.robot):
        return N_("The lesson needs its own experiment"), N_("It has been restarted. Leave the lessons for another one.")
    if not walk.yours and not session.settings.page.autopilot:
        return N_("The lesson moves this one"), N_("The run has been restarted. It is your turn where the step asks you to pull.")
    return None
