"""The imitated person: a smaller figure beside the robots."""

from typing import Final

import numpy as np
import viser

from app.i18n.speaking import tr
from app.session.frame import Frame
from app.settings import PageSettings
from app.stage.stage_part import StagePart, fresh
from app.theme import scale
from controllers.kinematics import Array
from scenes.person.body import SHOULDER_HEIGHT, body_parts, body_poses
from scenes.person.source import MissingPackage
from scenes.targets import AnglesTarget

SCALE: Final = 0.92 / SHOULDER_HEIGHT
"""Scale that puts its shoulders at the robots' height [m/m]."""

STAND: Final = np.array([-0.60, -1.05, 0.0])
"""Place (3,) [m]: right of the robots, a step behind, out of their reach."""

_SHOULDERS: Final = STAND + np.array([0.0, 0.0, SCALE * SHOULDER_HEIGHT])


def on_stage(point: Array) -> Array:
    """World position (3,) [m] of a point (3,) in the person's torso frame [m]."""
    return _SHOULDERS + SCALE * point


def on_person(point: Array) -> Array:
    """Inverse of `on_stage`."""
    return (point - _SHOULDERS) / SCALE


class FigureView(StagePart):
    """Five nested nodes, of which four turn; empty without the human model's package."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self.parts: dict[str, viser.GlbHandle] = {}
        """By the names of `scenes.person.body`."""
        self._label: viser.LabelHandle | None = None
        self.angles = np.full((2, 4), np.nan)
        """Drawn angles (2, 4) [rad]; nan before a person was seen."""
        try:
            parts = body_parts()
        except MissingPackage:
            return
        paths: dict[str, str] = {}
        for part in parts:
            path = paths[part.name] = f"{paths.get(part.parent, '/person')}/{part.name}"
            place = SCALE * part.pose.translation + (0.0 if part.parent else STAND)
            self.parts[part.name] = fresh(
                scene.add_glb(path, part.glb, scale=SCALE, position=tuple(place.tolist()))
            )
        above = _SHOULDERS + np.array([0.0, 0.0, 0.33])
        self._label = scene.add_label(
            "/person/lost", tr("no person in view"), anchor="bottom-center", position=above, visible=False
        )
        self.nodes = (self._label, self.parts["body"])

    def dress(self, page: PageSettings) -> None:
        if self._label is not None:
            self._label.font_screen_scale = 1.15 * scale(page.profile)

    def show(self, frame: Frame) -> None:
        """Without a person the arms stay, and a label says so."""
        if self._label is None:
            return
        angles = frame.target.angles if isinstance(frame.target, AnglesTarget) else None
        self._label.visible = angles is None
        if angles is None or np.array_equal(angles, self.angles):
            return
        self.angles = angles.copy()
        for name, turn in body_poses(angles).items():
            self.parts[name].wxyz = turn
