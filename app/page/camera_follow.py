"""A visitor's camera, which follows the experiment."""

import math
from collections import deque
from collections.abc import Callable
from typing import Final

import numpy as np
import viser

from app.page.picture_size import FreePicture, PictureReport
from app.stage.camera_view import Balls, PointView, Pose, axes, fit, framed_now, hands, joints, project
from controllers.kinematics import Array
from scenes.rigs import Camera
from scenes.simulation import Simulation

GLIDE: Final = 1.4
"""Duration of a camera move [s of wall time]."""

REST: Final = 1.5
"""Least rest after a move [s of wall time]."""

LOOK_EVERY: Final = 0.2
"""Time between two checks [s of wall time]."""

RECENT: Final = 25
"""Number of recent hand positions that stay in view."""

NEAR_EDGE: Final = 0.04
"""Margin of the free part at which the camera follows [share]."""

ROOM: Final = 0.12
"""Margin of the free part after a move [share]."""

SETTLING: Final = 6.0
"""Time in which a newcomer's camera follows changes of layout at once [s of wall time]."""

STAYS: Final = 0.7
"""Ratio of camera distances below which the other free part is used."""

WAY: Final = 0.05
"""Space shown around a hand's path [m]."""

SAME: Final = 0.004
"""Largest error of the browser's report of a sent camera [m]."""

UPRIGHT: Final = 1e-6
"""Horizontal distance below which a camera looks straight down or up [m]."""

LABEL_EDGE: Final = 4.0
"""Free space around a label [CSS px]."""

MOST_SENT: Final = 1000
"""Largest number of sent cameras without a report."""


class CameraFollow:
    """Moves the camera of one client.

    Args:
        way: next points (k, 3) of the hand or the ball [m].

    Attributes:
        left_alone: the visitor has moved the camera since the last first view.
    """

    def __init__(
        self,
        camera: viser.CameraHandle,
        aim: Callable[[Pose], None],
        view: Callable[[], Camera],
        way: Callable[[], Array],
        picture: PictureReport,
    ) -> None:
        self._camera, self._aim, self.picture = camera, aim, picture
        self._view, self._way = view, way
        self.left_alone = False
        self._pose: Pose | None = None
        self._glide: tuple[float, Pose, Pose] | None = None
        self._sent: list[tuple[Array, Array]] = []
        self._recent: deque[Array] = deque(maxlen=RECENT)
        self._next = self._rest_until = self._settles_until = 0.0
        self._part: int | None = None
        self._point_view: PointView | None = None

    def first_view(self, simulation: Simulation, now: float) -> None:
        """Show the whole experiment, then follow. `now`: wall time [s]."""
        self.left_alone, self._glide, self._part = False, None, None
        self._recent.clear()
        camera = self._camera
        # The browser's next report may be older than this.
        self._sent.append((np.array(camera.position), np.array(camera.look_at)))
        camera.up_direction = np.array([0.0, 0.0, 1.0])
        self._send(self._fitted(simulation))
        self._rest_until = now + REST

    def welcome(self, simulation: Simulation, now: float) -> None:
        """`first_view`, repeated while the page's layout settles."""
        self.first_view(simulation, now)
        # The docked panel narrows the picture a moment after the page has opened; only the browser knows by
        # how much.
        self._settles_until = now + SETTLING

    def follow(self, simulation: Simulation, now: float, dragging: bool = False) -> None:
        """Move the camera if the free parts change or something leaves them.

        Args:
            now: wall time [s].
            dragging: True keeps the view, which would move what is dragged.
        """
        if now <= self._settles_until and not self.left_alone and self.picture.take_change():
            self.first_view(simulation, now)
        if dragging:
            return
        changed, looks = self.picture.take_change(), now >= self._next
        if (
            self._pose is None
            or self.left_alone
            or not (changed or looks or self._glide)
            or self._moved_by_visitor()
        ):
            return
        if changed:
            # The visitor has folded or opened the plots, or resized the window.
            self._glide = now, self._pose, self._fitted(simulation)
        if looks:
            self._next = now + LOOK_EVERY
            self._recent.append(hands(simulation))
        if self._glide is not None:
            self._go_on(now)
            return
        picture, share = self.picture.free(), NEAR_EDGE if now >= self._rest_until else 0.0
        seen = project(self._pose, (picture.width, picture.height), framed_now(simulation)[0])
        if not all(picture.contains(x, y, share) for x, y in seen):
            self._glide = now, self._pose, self._fitted(simulation)

    def keep_free(self, place: Array, label: tuple[float, float]) -> tuple[Array, bool]:
        """Nearest place where a label is neither cut nor covered.

        Args:
            place: middle of its lower edge (3,) [m].
            label: width and height [CSS px].

        Returns:
            New place (3,) [m], and True if the old one is free. Unchanged behind the eye and if the camera
                looks straight down.
        """
        camera, pose, known = self._camera, self._pose, self._point_view
        if self.left_alone:
            pose = Pose(camera.position, camera.look_at, camera.fov)
        if pose is None:
            return place, True
        # A camera that rests keeps its very arrays.
        if known is None or not all(one is other for one, other in zip(known.pose, pose, strict=True)):
            if np.linalg.norm((pose.eye - pose.look_at)[:2]) < UPRIGHT:
                return place, True
            known = self._point_view = PointView(pose)
        return kept_free(known, self.picture.free(), place, label)

    def _moved_by_visitor(self) -> bool:
        """True if the browser reports a camera that it was never sent. Position and aim are compared
        separately, because a report may mix an old position with a new aim."""
        said = np.asarray(self._camera.position), np.asarray(self._camera.look_at)
        known = [
            next((k for k, sent in enumerate(self._sent) if np.abs(sent[i] - said[i]).max() < SAME), None)
            for i in range(2)
        ]
        self.left_alone = None in known
        del self._sent[: min(k or 0 for k in known)]
        return self.left_alone

    def _go_on(self, now: float) -> None:
        assert self._glide is not None
        begun, start, end = self._glide
        s = min((now - begun) / GLIDE, 1.0)
        s *= s * (3.0 - 2.0 * s)
        self._send(
            Pose(
                start.eye + s * (end.eye - start.eye),
                start.look_at + s * (end.look_at - start.look_at),
                end.fov,
            )
        )
        if s >= 1.0:
            self._glide, self._rest_until = None, now + REST

    def _send(self, pose: Pose) -> None:
        self._pose = pose
        if len(self._sent) >= MOST_SENT:
            # A hidden tab keeps its camera, and then goes to the newest.
            del self._sent[1 : MOST_SENT // 2]
        self._sent.append((pose.eye, pose.look_at))
        self._aim(pose)

    def _fitted(self, simulation: Simulation) -> Pose:
        view, picture = self._view(), self.picture.free()
        size, toward = (picture.width, picture.height), np.array(view.toward)
        centres, radii = framed_now(simulation)
        # The path from A to B past the ball, or round a circle; every eighth of many points is enough.
        prescribed = simulation.way[::8] if len(simulation.way) > 8 else simulation.way
        ways = np.concatenate([self._way(), prescribed, *self._recent])
        centres, radii = np.concatenate([centres, ways]), np.concatenate([radii, np.full(len(ways), WAY)])
        corners = np.concatenate([view_corners(view), joints(simulation)])
        whole = Balls(corners, np.zeros(len(corners)), picture.open)
        poses = [
            fit(toward, view.fov, size, (Balls(centres, radii, part.inset(ROOM)), whole))
            for part in picture.free
        ]
        away = [float(np.linalg.norm(pose.eye - view.centre)) for pose in poses]
        if self._part is not None and self._part < len(away):
            away[self._part] *= STAYS
        self._part = int(np.argmin(away))
        return poses[self._part]


def view_corners(view: Camera) -> Array:
    """Corners (4, 3) of what a view must show [m]."""
    right, up, _ = axes(np.array(view.toward))
    corners = [
        x * view.width / 2.0 * right + y * view.height / 2.0 * up for x in (-1.0, 1.0) for y in (-1.0, 1.0)
    ]
    return np.array(view.centre) + np.array(corners)


def kept_free(
    view: PointView, picture: FreePicture, place: Array, label: tuple[float, float]
) -> tuple[Array, bool]:
    """See `CameraFollow.keep_free`."""
    x, y, metre = view.pixel(place, picture.width, picture.height)
    if math.isnan(x):
        return place, True
    width, height = label[0] + 2.0 * LABEL_EDGE, label[1] + 2.0 * LABEL_EDGE
    moves = []
    for part in picture.free:
        left, right = part.left + width / 2.0, max(part.right - width / 2.0, part.left + width / 2.0)
        top, bottom = part.top + height, max(part.bottom, part.top + height)
        moves.append((min(max(x, left), right) - x, min(max(y + LABEL_EDGE, top), bottom) - LABEL_EDGE - y))
    across, down = min(moves, key=lambda move: move[0] ** 2 + move[1] ** 2)
    if across == 0.0 == down:
        return place, True
    rightward, upward, _ = view.axes
    return place + metre * (across * rightward - down * upward), False
