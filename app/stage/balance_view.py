"""Foot and centre of mass of an arm on a cart."""

from typing import Final

import numpy as np
import viser

from app.session.frame import Frame
from app.settings import PageSettings
from app.stage.stage_part import StagePart
from app.theme import PALETTES, Rgb, rgb
from controllers.first_tasks.centre_of_mass import CentreOfMass
from scenes.first_task.detector import FirstTaskDetector
from scenes.simulation import Simulation

LOAD_RADIUS: Final = 0.031
"""Radius of a steel ball of 1 kg [m]."""

ABOVE: Final = 0.004
"""Height of lines above the floor [m]."""


def balance_of(simulation: Simulation) -> CentreOfMass | None:
    """First task that keeps the centre of mass."""
    detector = simulation.detector
    tasks = detector.tasks if isinstance(detector, FirstTaskDetector) else ()
    return next((task for task in tasks if isinstance(task, CentreOfMass)), None)


class BalanceView(StagePart):
    """Visible with the contact, if there is a foot."""

    def __init__(self, scene: viser.SceneApi, task: CentreOfMass) -> None:
        line = np.zeros((1, 2, 3), np.float32)
        self._foot = scene.add_line_segments(
            "/balance/foot", line, (0, 0, 0), thickness=4, thickness_units="screen"
        )
        self._kept = scene.add_line_segments(
            "/balance/kept", line, (0, 0, 0), thickness=2, thickness_units="screen"
        )
        self._plumb = scene.add_line_segments(
            "/balance/plumb", line, (0, 0, 0), thickness=2, thickness_units="screen"
        )
        self._centre = scene.add_icosphere("/balance/centre", radius=0.03, subdivisions=3, cast_shadow=False)
        self._load = scene.add_icosphere("/balance/load", radius=LOAD_RADIUS, subdivisions=3)
        self.nodes = (self._foot, self._kept, self._plumb, self._centre, self._load)
        self._foot.points = _outline(task, 0.0)
        self._drawn = -1.0

    def dress(self, page: PageSettings) -> None:
        self._on, palette = page.contact, PALETTES[page.theme]
        for node, colour in (
            (self._foot, palette.ink),
            (self._kept, palette.activation),
            (self._plumb, palette.ink),
        ):
            node.colors = np.array(rgb(colour), np.uint8)
        self._load.color = rgb(palette.faint)
        self._colours: tuple[Rgb, Rgb] = rgb(palette.distance), rgb(palette.approach)

    def show(self, frame: Frame) -> None:
        task = balance_of(frame.simulation)
        for node in self.nodes:
            node.visible = self._on and task is not None
        if task is None or not self._on:
            return
        kept = frame.simulation.settings.law.critical_distance
        if kept != self._drawn:
            self._drawn = kept
            self._kept.points = _outline(task, kept)
        simulation = frame.simulation
        pose = simulation.kinematics.hand_pose(simulation.avoiding)
        # A ball of steel, the larger the heavier.
        radius = LOAD_RADIUS * simulation.settings.load ** (1.0 / 3.0)
        self._load.visible = radius > 0.0
        self._load.scale = max(radius, 1e-3) / LOAD_RADIUS
        self._load.position = pose.translation + pose.rotation[:, 2] * radius
        centre, (ground, _) = task.centre(), task.ground_points()
        self._centre.position = centre
        self._centre.color = self._colours[int(task.margin().value < 0.0)]
        self._plumb.points = np.array([[centre, ground]], np.float32)


def _outline(task: CentreOfMass, inside: float) -> np.ndarray:
    """Edges (4, 2, 3) of the foot, moved inwards [m]; all at its centre if nothing is left."""
    (x, y), half = task.foot.centre.tolist(), np.maximum(task.foot.half - inside, 0.0)
    a, b = half.tolist()
    corners = np.array(
        [[x - a, y - b, ABOVE], [x + a, y - b, ABOVE], [x + a, y + b, ABOVE], [x - a, y + b, ABOVE]]
    )
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1).astype(np.float32)
