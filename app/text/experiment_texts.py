"""The words of every experiment: what to do in it, and what to watch."""

from collections.abc import Callable
from typing import Final, NamedTuple

from app.i18n.speaking import N_, tr
from scenes.experiments import BALL, HOLD, IMITATION, MASTER_SLAVE, SOLO
from scenes.settings import RunSettings


class ExperimentTexts(NamedTuple):
    """What is said of an experiment, in the reader's language.

    Attributes:
        tip: returns one or two sentences on what to do and what to watch; the second argument says whether it runs by itself.
        watched: returns what to watch alone, without who moves the orange arm.
    """

    tip: Callable[[RunSettings, bool], str]
    watched: Callable[[RunSettings], str]


SWINGS: Final = N_("The elbow moves in the null space of the hand: |e| stays small.")


def _solo_tip(run: RunSettings, itself: bool) -> str:
    if run.path == "circle":
        return tr("The hand draws a circle. Take K down to 0 and it drifts; raise K times and dt until K dt > 2.")
    drag = tr("Pull the arm at its elbow, or its hand to another place.")
    does = tr("The autopilot swings the elbow; pull the arm anywhere to take over.") if itself else drag
    return f"{does} {tr(SWINGS)}"


def _solo(run: RunSettings) -> str:
    return tr("The hand draws a circle.") if run.path == "circle" else tr(SWINGS)


def _ball_tip(run: RunSettings, itself: bool) -> str:
    crosses = itself and run.ball == "cross"
    return f"{_ball(run)} {tr('The ball crosses the path by itself; drag it.') if crosses else tr('Drag the ball.')}"


def _ball(run: RunSettings) -> str:
    what = {"hand": tr("its hand"), "elbow": tr("its elbow"), "arm": tr("all of it")}[run.point]
    return tr("The arm takes its hand from A to B and back, and keeps {what} clear of the ball.", what=what)


def _hold_tip(run: RunSettings, itself: bool) -> str:
    takes_over = tr("The autopilot moves the orange arm; pull it anywhere to take over.")
    return f"{takes_over if itself else tr('Pull the orange arm anywhere.')} {_hold(run)}"


def _hold(run: RunSettings) -> str:
    if run.avoid == "guided":
        return tr("It keeps clear of the silver arm, which keeps its hand in the ring.")
    if run.avoid == "both":
        return tr("The silver arm keeps its hand in the ring as long as it can, and both keep clear.")
    return tr("The silver arm keeps its hand in the ring as long as it can, and keeps clear.")


def _master_slave_tip(run: RunSettings, itself: bool) -> str:
    takes_over = tr("The autopilot moves the orange arm, the master; pull it anywhere to take over.")
    return f"{takes_over if itself else tr('Pull the orange arm, the master, anywhere.')} {_master_slave(run)}"


def _master_slave(run: RunSettings) -> str:
    avoids = _avoids(run, tr("keeps clear"), tr("the master keeps clear"))
    if run.following == "mirrored":
        return tr("The silver arm follows it in a mirror, and {avoids}.", avoids=avoids)
    return tr("The silver arm follows it joint by joint, and {avoids}.", avoids=avoids)


def _imitation_tip(run: RunSettings, itself: bool) -> str:
    del itself
    return f"{_imitation(run)} {tr('Pull the arms of the figure anywhere.')}"


def _imitation(run: RunSettings) -> str:
    return tr(
        "Both arms follow the person by four angles each, and {avoids}. See-through: where they ought to be.",
        avoids=_avoids(run, tr("the other one keeps clear"), tr("your own one keeps clear")),
    )


def _avoids(run: RunSettings, free: str, guided: str) -> str:
    """Return who keeps clear. `free`, `guided`: what is said where it is one of them alone."""
    return tr("both keep clear of each other") if run.both_avoid else {"free": free, "guided": guided}[run.avoid]


EXPERIMENT_TEXTS: Final[dict[str, ExperimentTexts]] = {
    SOLO: ExperimentTexts(_solo_tip, _solo),
    BALL: ExperimentTexts(_ball_tip, _ball),
    HOLD: ExperimentTexts(_hold_tip, _hold),
    MASTER_SLAVE: ExperimentTexts(_master_slave_tip, _master_slave),
    IMITATION: ExperimentTexts(_imitation_tip, _imitation),
}
"""Name → what is said of it."""
