"""First tasks of one arm in place of the distance of two."""

import math

import numpy as np
import pinocchio as pin

from controllers.choices import Treatment
from controllers.first_tasks.centre_of_mass import CentreOfMass
from controllers.first_tasks.first_task import FirstTask, Margin
from controllers.first_tasks.joint_stops import JointStops
from controllers.first_tasks.points_over_plane import Plane, PointsOverPlane
from controllers.kinematics import Array
from controllers.proximity import Proximity, ProximityDetector, smooth_minimum
from scenes.first_task.wall import normal_of
from scenes.room import World


class FirstTaskDetector(ProximityDetector):
    """First tasks of an arm, each in place of a pair of bodies.

    Args:
        world: only its detector may be missing.
        tasks: at least one. All have one h_m, each in its unit, so that λ is that of the least ratio h/h_m.
        names: what each keeps clear of.
        posture: q (nv,) that they read, filled by `detect`.
        wall: columns of the wall in q, or None.
        stages: the law acts on the first task alone; stages keep the others.
    """

    def __init__(
        self,
        world: World,
        tasks: tuple[FirstTask, ...],
        names: tuple[str, ...],
        posture: Array,
        wall: slice | None = None,
        stages: bool = False,
    ) -> None:
        super().__init__(world.kinematics, pin.GeometryModel())
        self.tasks, self._wall, self._stages = tasks, wall, stages
        self.pair_names = tuple((world.room.arms[0].name, name) for name in names)
        self._arm, self._posture = world.room.arms[0], posture
        self._joints = self._arm.joints
        self._values, self._all_rows = np.zeros(len(tasks)), np.zeros((len(tasks), world.room.model.nv))

    @property
    def count(self) -> int:
        return len(self.tasks)

    def detect(
        self, treatment: Treatment = "single", beta: float = 100.0, epsilon: float = 1e-4
    ) -> Proximity:
        """Value, row and index of the least task at the last `kinematics.update`.

        Args:
            treatment: "single" for the least task, else their smooth minimum.
            beta: over the unit of h.
        """
        del epsilon
        self._posture[:] = self.kinematics.positions
        for i, task in enumerate(self.tasks):
            margin = self._margin(task)
            self._values[i] = margin.value
            self._all_rows[i, self._joints] = margin.row
        least = int(self._values.argmin())
        value, row = float(self._values[least]), self._all_rows[least].copy()
        if self._stages:
            return Proximity(value, least, float(self._values[0]), self._all_rows[0].copy(), row)
        if treatment == "single" or len(self.tasks) == 1:
            return Proximity(value, least, value, row, row)
        together = np.empty(len(row))
        law_value = float(smooth_minimum(self._values, self._all_rows, beta, together))
        return Proximity(value, least, law_value, together, row)

    def _margin(self, task: FirstTask) -> Margin:
        if self._wall is None or not isinstance(task, PointsOverPlane):
            return task.margin()
        # w of a wall that turns at 1 rad/s, or comes at 1 m/s, is the column of its own joint in the row.
        at = self._posture[self._wall]
        point, (turn, tilt) = at[:3].copy(), at[3:].tolist()
        normal, row = normal_of(turn, tilt), self._all_rows[self.tasks.index(task)]
        row[self._wall.start : self._wall.start + 3] = -normal
        rest = np.zeros(3)
        axes = np.array([[0.0, 0.0, 1.0], [-math.sin(turn), math.cos(turn), 0.0]])
        margin = None
        for column, axis in zip(range(self._wall.start + 3, self._wall.stop), axes, strict=True):
            task.plane = Plane(normal, point, rest, axis)
            margin = task.margin()
            row[column] = -margin.approach
        assert margin is not None
        return margin

    def row(self, pair: int) -> Array:
        return self._all_rows[pair].copy()

    def rows(self) -> Array:
        return self._all_rows.copy()

    def distances(self) -> Array:
        return self._values.copy()

    def witness_points(self, pair: int) -> tuple[Array, Array]:
        """Ends (3,) of the drawn line of a value, world [m]; equal if it is not a length."""
        task = self.tasks[pair]
        if isinstance(task, PointsOverPlane):
            point = task.nearest_point()
            plane = task.plane
            return point, point - plane.normal * float(plane.normal.dot(point - plane.point))
        if isinstance(task, CentreOfMass):
            return task.ground_points()
        arm = self._arm
        if isinstance(task, JointStops):
            joint = arm.joints.start + 1 + int(np.abs(self._all_rows[pair, arm.joints]).argmax())
            place = self.kinematics.joint_point(joint)
        else:
            place = self.kinematics.hand_pose(arm).translation.copy()
        return place, place
