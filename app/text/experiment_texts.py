"""Experiments' texts: what to do and what to watch."""

from collections.abc import Callable
from typing import Final, NamedTuple

from app.i18n.speaking import tr
from scenes.experiments import BALL, FIRST_TASK, HOLD, IMITATION, MASTER_SLAVE, SOLO
from scenes.quantities import ALL, SINGULAR, STOPS, TIP, WALL
from scenes.settings import RunSettings


class ExperimentTexts(NamedTuple):
    """Translated texts of an experiment.

    Attributes:
        tip: what to do and watch, in one or two sentences.
        watched: only what to watch, if the orange arm moves by itself.
    """

    tip: str
    watched: str


def _solo(run: RunSettings, itself: bool) -> ExperimentTexts:
    if run.path == "circle":
        circle = tr(
            "The hand draws a circle. Take K down to 0 and it drifts; raise K times and dt until K dt > 2."
        )
        return ExperimentTexts(circle, tr("The hand draws a circle."))
    drag = tr("Pull the arm at its elbow, or its hand to another place.")
    does = tr("The autopilot swings the elbow; pull the arm anywhere to take over.") if itself else drag
    swings = tr("The elbow moves in the null space of the hand: |e| stays small.")
    return ExperimentTexts(f"{does} {swings}", swings)


def _ball(run: RunSettings, itself: bool) -> ExperimentTexts:
    what = {"hand": tr("its hand"), "elbow": tr("its elbow"), "arm": tr("all of it")}[run.point]
    watched = tr(
        "The arm takes its hand from A to B and back, and keeps {what} clear of the ball.", what=what
    )
    crosses = itself and run.ball == "cross"
    drag = tr("The ball crosses the path by itself; drag it.") if crosses else tr("Drag the ball.")
    return ExperimentTexts(f"{watched} {drag}", watched)


def _hold(run: RunSettings, itself: bool) -> ExperimentTexts:
    takes_over = tr("The autopilot moves the orange arm; pull it anywhere.")
    if run.avoid == "guided":
        watched = tr("It keeps clear of the silver arm, which keeps its hand in the ring.")
    elif run.avoid == "both":
        watched = tr("The silver arm keeps its hand in the ring as long as it can, and both keep clear.")
    else:
        watched = tr("The silver arm keeps its hand in the ring as long as it can, and keeps clear.")
    tip = takes_over if itself else tr("Pull the orange arm anywhere.")
    # The welcome text describes the silver arm.
    return ExperimentTexts(f"{tip} {watched}" if run.avoid in ("guided", "both") else tip, watched)


def _master_slave(run: RunSettings, itself: bool) -> ExperimentTexts:
    takes_over = tr("The autopilot moves the orange arm, the master; pull it anywhere to take over.")
    avoids = _avoids(run, tr("keeps clear"), tr("the master keeps clear"))
    if run.following == "mirrored":
        watched = tr("The silver arm follows it in a mirror, and {avoids}.", avoids=avoids)
    else:
        watched = tr("The silver arm follows it joint by joint, and {avoids}.", avoids=avoids)
    return ExperimentTexts(
        f"{takes_over if itself else tr('Pull the orange arm, the master, anywhere.')} {watched}", watched
    )


def _imitation(run: RunSettings, itself: bool) -> ExperimentTexts:
    del itself
    watched = tr(
        "Both arms follow the person by four angles each, and {avoids}. The translucent arms show where they should be.",
        avoids=_avoids(run, tr("the other one keeps clear"), tr("your own one keeps clear")),
    )
    return ExperimentTexts(f"{watched} {tr('Pull the arms of the figure anywhere.')}", watched)


def _first_task(run: RunSettings, itself: bool) -> ExperimentTexts:
    watched = {
        WALL: tr("Elbow, wrist and hand keep their distance from the wall."),
        STOPS: tr("No joint comes near its stops."),
        SINGULAR: tr("The arm never stretches out: it keeps away from singular postures."),
        TIP: tr("The centre of mass stays over the cart's foot. The masses of the links are estimates."),
        ALL: tr("The arm keeps all of these at once; the least margin counts."),
    }[run.first]
    takes_over = tr("The autopilot shows it; drag the hand to take over.")
    drag = (
        tr("Drag the hand, or the wall.")
        if run.first in (WALL, ALL)
        else tr("Drag the hand as far as you can.")
    )
    return ExperimentTexts(f"{takes_over if itself else drag} {watched}", watched)


def _avoids(run: RunSettings, free: str, guided: str) -> str:
    return (
        tr("both keep clear of each other") if run.both_avoid else {"free": free, "guided": guided}[run.avoid]
    )


EXPERIMENT_TEXTS: Final[dict[str, Callable[[RunSettings, bool], ExperimentTexts]]] = {
    SOLO: _solo,
    BALL: _ball,
    HOLD: _hold,
    MASTER_SLAVE: _master_slave,
    IMITATION: _imitation,
    FIRST_TASK: _first_task,
}
"""The second argument is True if the experiment runs by itself."""
