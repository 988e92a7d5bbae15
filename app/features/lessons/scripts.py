"""Scripted inputs: pure functions of the simulation.

Lengths in m, speeds in m/s, angles in rad, times in s. `after`: first delay.
"""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np

from app.features.measures.quantities.quantity import read_parameters
from app.features.measures.room_places import RoomPlace, ball_centre
from controllers.errors import BadSetting
from controllers.kinematics import Array
from scenes.ball import BALL_RADIUS, POINT_RADIUS
from scenes.experiments import EXPERIMENTS, Moved, Obstacle
from scenes.roles import Scripted
from scenes.simulation import Simulation
from scenes.solo import NullMotions, swing
from scenes.targets import BallTarget, HandTarget, JointTarget, Target, WallTarget, quintic

Motion = Callable[[float], Target]
"""Time [s] → target."""

POSTURES: Final = 150


def _hand(simulation: Simulation) -> Array:
    simulation.kinematics.update(simulation.positions)
    return simulation.kinematics.hand_pose(simulation.guided).translation.copy()


def _straight(
    begin: Array, way: Array, speed: float, after: float = 0.0, beyond: float = 0.0
) -> Callable[[float], Array]:
    """Time → position (3,), at constant speed. `beyond`: extension past the end."""
    length = float(np.linalg.norm(way))
    longest = max(length + beyond, 0.0)
    return lambda time: (
        begin + way * (min(speed * max(time - after, 0.0), longest) / length if length else 0.0)
    )


def push(
    simulation: Simulation,
    speed: float,
    at: Literal["hand", "wrist", "elbow"] = "hand",
    after: float = 1.0,
    seconds: float = 60.0,
) -> Motion:
    """The hand moves straight to the other arm's hand, wrist or elbow and past it, for `seconds`."""
    begin, kinematics, other = _hand(simulation), simulation.kinematics, simulation.avoiding
    goal = {
        "hand": kinematics.hand_pose(other).translation.copy(),
        "wrist": kinematics.joint_point(other.wrist),
        "elbow": kinematics.joint_point(other.elbow),
    }[at]
    way = (goal - begin) / max(float(np.linalg.norm(goal - begin)), 1e-9) * speed
    return lambda time: HandTarget(begin + way * min(max(time - after, 0.0), seconds))


def push_and_back(
    simulation: Simulation, share: float = 0.7, seconds: float = 3.0, rest: float = 1.0
) -> Motion:
    """The hand moves softly to and fro, by a share of the way to the other arm's hand.

    Parameters: seconds for one way; rest at either end.
    """
    begin = _hand(simulation)
    way = (simulation.kinematics.hand_pose(simulation.avoiding).translation.copy() - begin) * share
    return lambda time: HandTarget(begin + way * to_and_fro(time, seconds, rest))


def to_and_fro(time: float, seconds: float, rest: float) -> float:
    """Share in [0, 1] of a soft motion to and fro, with a rest before each; 0 at time 0."""
    leg, t = divmod(max(time, 0.0), seconds + rest)
    share, _ = quintic(min(max((t - rest) / max(seconds, 1e-9), 0.0), 1.0))
    return 1.0 - share if int(leg) % 2 else share


def hand_to(
    simulation: Simulation, x: float = 0.0, y: float = 0.0, z: float = 0.0, speed: float = 0.1
) -> Motion:
    """The hand (of a single arm, the protected one's) moves straight by (x, y, z), and stays."""
    place = _straight(_hand(simulation), np.array([x, y, z]), speed)
    return lambda time: HandTarget(place(time))


def hand_circle(simulation: Simulation, radius: float = 0.1, period: float = 6.0) -> Motion:
    """The hand follows a vertical circle from its start."""
    begin = _hand(simulation)
    return lambda time: HandTarget(begin + _circle(time, radius, period, along_y=True))


def elbow_to(simulation: Simulation, angle: float = 0.4, period: float = 8.0) -> Motion:
    """The elbow swings to either side about the line from shoulder to wrist; the hand keeps its pose."""
    simulation.kinematics.update(simulation.positions)
    swung = swing(simulation.kinematics, simulation.avoiding)
    return lambda time: swung(angle * np.sin(2.0 * np.pi * time / max(period, 1e-3)))


def null_motions(
    simulation: Simulation,
    swing: float = 0.5,
    x: float = 0.0,
    y: float = 0.0,
    z: float = 0.0,
    seconds: float = 3.0,
) -> Motion:
    """The arm follows its null-space motions in turn, and stays; the hand keeps its place.

    Parameters: swing of the elbow; x, y, z, turns of the hand; seconds for each of the four.
    """
    motions = NullMotions(simulation.room, simulation.avoiding, simulation.positions)
    shares = [quintic(i / POSTURES)[0] for i in range(1, POSTURES + 1)]
    postures = [motions.joints]
    postures += [motions.go(i, way * share) for i, way in enumerate((swing, x, y, z)) for share in shares]

    def motion(time: float) -> Target:
        return JointTarget(
            postures[min(round(max(time, 0.0) / max(seconds, 1e-3) * POSTURES), len(postures) - 1)]
        )

    return motion


def ball_to(simulation: Simulation, place: RoomPlace, speed: float = 0.2, after: float = 0.0) -> Motion:
    """The ball moves straight to a place, and stays."""
    begin = _ball(simulation)
    centre = _straight(begin, ball_centre(simulation.room, place) - begin, speed, after)
    return lambda time: BallTarget(centre(time))


def ball_push(simulation: Simulation, speed: float, after: float = 0.5, gap: float = -1.0) -> Motion:
    """The ball moves straight to the hand's start and past it.

    Parameters: gap, distance at which it stops; negative for beyond the hand.
    """
    begin = _ball(simulation)
    centre = _straight(begin, _hand(simulation) - begin, speed, after, -gap - BALL_RADIUS - POINT_RADIUS)
    return lambda time: BallTarget(centre(time))


def ball_circle(simulation: Simulation, radius: float = 0.15, period: float = 6.0) -> Motion:
    """The ball follows a vertical circle from its start."""
    begin = _ball(simulation)
    return lambda time: BallTarget(begin + _circle(time, radius, period, along_y=False))


def _circle(time: float, radius: float, period: float, along_y: bool) -> Array:
    phase = 2.0 * np.pi * time / max(period, 1e-3)
    aside = np.sin(phase)
    return radius * np.array([0.0 if along_y else aside, aside if along_y else 0.0, 1.0 - np.cos(phase)])


def _ball(simulation: Simulation) -> Array:
    columns = simulation.room.ball
    assert columns is not None
    return simulation.positions[columns].copy()


def wall_to(
    simulation: Simulation,
    x: float = 0.0,
    y: float = 0.0,
    z: float = 0.0,
    tilt: float = 0.0,
    speed: float = 0.2,
    after: float = 0.0,
) -> Motion:
    """The wall moves straight by (x, y, z), tilts on the way (positive looks up), and stays."""
    columns = simulation.room.wall
    if columns is None:
        raise BadSetting("The script wall_to needs a wall; set first = wall or first = all.")
    begin, way = simulation.positions[columns].copy(), np.array([x, y, z])
    place, length = _straight(begin[:3], way, speed, after), float(np.linalg.norm(way))

    def motion(time: float) -> Target:
        here = place(time)
        share = float(np.linalg.norm(here - begin[:3])) / length if length else 1.0
        return WallTarget(here, begin[3:] + np.array([0.0, tilt * share]))

    return motion


@dataclass(frozen=True)
class ScriptEntry:
    """A script.

    Attributes:
        make: (simulation that has just begun, parameters) → motion.
        beside: obstacles with which it fits.
    """

    make: Callable[..., Motion]
    moves: Moved
    beside: tuple[Obstacle, ...]

    def fits(self, scene: str) -> bool:
        experiment = EXPERIMENTS[scene]
        return experiment.moves == self.moves and experiment.obstacle in self.beside

    @property
    def parameters(self) -> dict[str, inspect.Parameter]:
        return dict(list(inspect.signature(self.make).parameters.items())[1:])

    @property
    def places(self) -> tuple[str, ...]:
        return tuple(key for key, parameter in self.parameters.items() if parameter.annotation is RoomPlace)


SCRIPTS: Final[dict[str, ScriptEntry]] = {
    "push": ScriptEntry(push, "arm", ("arm",)),
    "push_and_back": ScriptEntry(push_and_back, "arm", ("arm",)),
    "hand_to": ScriptEntry(hand_to, "arm", ("arm", "nothing", "task")),
    "hand_circle": ScriptEntry(hand_circle, "arm", ("arm", "nothing", "task")),
    "elbow_to": ScriptEntry(elbow_to, "arm", ("nothing",)),
    "null_motions": ScriptEntry(null_motions, "arm", ("nothing",)),
    "wall_to": ScriptEntry(wall_to, "arm", ("task",)),
    "ball_to": ScriptEntry(ball_to, "ball", ("ball",)),
    "ball_push": ScriptEntry(ball_push, "ball", ("ball",)),
    "ball_circle": ScriptEntry(ball_circle, "ball", ("ball",)),
}


def checked_script(name: str, given: Mapping[str, Any], scene: str) -> tuple[tuple[str, Any], ...]:
    """Check a script's parameters; places are `RoomPlace` already.

    Raises:
        BadSetting: unknown script or parameter, impossible value, or nothing to move in the scene.
    """
    if name not in SCRIPTS:
        raise BadSetting(f"There is no script {name[:40]!r}; choose from {', '.join(SCRIPTS)}.")
    known = SCRIPTS[name]
    if not known.fits(scene):
        fitting = ", ".join(other for other, one in SCRIPTS.items() if one.fits(scene))
        remedy = f"choose from {fitting}" if fitting else "no script has; choose another scene"
        raise BadSetting(f"The script {name} has nothing to move in the scene {scene}; {remedy}.")
    places = {key: value for key, value in given.items() if isinstance(value, RoomPlace)}
    wanted = known.parameters
    for key in places:
        if key not in known.places:
            raise BadSetting(f"script {name}: {key} is not a place; choose from {', '.join(wanted)}.")
    for key, value in given.items():
        if key not in wanted:
            remedy = f"choose from {', '.join(wanted)}" if wanted else "remove it, there are none"
            raise BadSetting(f"script {name} has no parameter {key!r}; {remedy}.")
        if key in known.places and key not in places:
            remedy = f"write {key} = {{ toward = [0.0, 1.0, 0.0], gap = 0.1 }}"
            raise BadSetting(f"script {name}: {key} = {value!r:.40} is not a place; {remedy}.")
    plain = {key: parameter for key, parameter in wanted.items() if key not in known.places}
    numbers = read_parameters(f"script {name}", plain, {k: v for k, v in given.items() if k not in places})
    missing = [key for key in known.places if key not in places]
    if missing:
        raise BadSetting(f"script {name} needs the place {missing[0]!r}.")
    return (*numbers, *places.items())


def script(name: str, parameters: tuple[tuple[str, Any], ...], simulation: Simulation) -> Scripted:
    return Scripted(SCRIPTS[name].make(simulation, **dict(parameters)))
