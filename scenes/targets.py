"""What a person, the autopilot or a recording wants at one moment: one kind of wish for each thing that can be taken hold of."""

from typing import NamedTuple

from controllers.kinematics import Array


class HandTarget(NamedTuple):
    """Where the person wants the arm that they hold.

    Attributes:
        position: of the hand (3,), world [m].
        rotation: of the hand (3, 3), or None if the person does not care.
        elbow: where the person pulls the elbow (3,), world [m], or None.
    """

    position: Array
    rotation: Array | None = None
    elbow: Array | None = None


class JointTarget(NamedTuple):
    """Where the person wants the joints of the arm that they hold: positions (n,) [rad]."""

    positions: Array


class LinkTarget(NamedTuple):
    """Where the person pulls a point of a link of the arm that they hold.

    Attributes:
        joint: that the link turns with, counted from 1 along the arm.
        offset: of the point in the joint's frame (3,) [m].
        position: where the point is pulled to (3,), world [m].
    """

    joint: int
    offset: Array
    position: Array


class BallTarget(NamedTuple):
    """Where the person wants the ball: its middle (3,), world [m]."""

    position: Array


class AnglesTarget(NamedTuple):
    """How a person holds their own arms.

    Attributes:
        angles: (2, 4), left arm first [rad], see `scenes.person.angles`; None while no person is seen.
    """

    angles: Array | None


Target = HandTarget | JointTarget | LinkTarget | BallTarget | AnglesTarget
