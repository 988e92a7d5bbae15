"""The line between the closest points, with d on it; its colour and its width are λ."""

from typing import Final

import numpy as np
import viser

from app.session.frame import Frame
from app.settings import PageSettings
from app.theme import PALETTES, Rgb, blend, scale

LABEL_ABOVE: Final = 0.02
"""How far the number stands above the middle of the line [m]."""


class ClosestLine:
    """Not to be seen where nothing is near; through everything else it is, by `contact_look.js`.

    Args:
        scene: where to draw.
    """

    def __init__(self, scene: viser.SceneApi) -> None:
        line = np.zeros((1, 2, 3), np.float32)
        self._line = scene.add_line_segments(
            "/closest/line", line, (0, 0, 0), thickness=3, thickness_units="screen", visible=False
        )
        self._ends = [
            scene.add_icosphere(f"/closest/end{i}", radius=0.011, subdivisions=2, cast_shadow=False, visible=False)
            for i in (0, 1)
        ]
        self._label = scene.add_label("/closest/distance", "", anchor="bottom-center", visible=False)
        self._seen = False
        self._colour: Rgb | None = None

    def dress(self, page: PageSettings) -> None:
        self._colour = None
        self._on, self._palette, self._scale = page.contact, PALETTES[page.theme], scale(page.profile)
        self._label.font_screen_scale = 1.15 * self._scale
        for end in self._ends:
            end.color = (40, 44, 50) if page.theme == "light" else (235, 240, 245)

    def show(self, frame: Frame) -> None:
        """Draw the pair that is closest now."""
        sample = frame.sample
        seen = self._on and sample.pair >= 0
        if seen != self._seen:
            self._seen = seen
            for part in (self._line, *self._ends, self._label):
                part.visible = seen
        if not seen:
            return
        a, b = frame.simulation.detector.witness_points(sample.pair)
        self._line.points = np.array([[a, b]], np.float32)
        for end, point in zip(self._ends, (a, b), strict=True):
            end.position = point
        lam = sample.activation
        colour = blend(self._palette.calm, self._palette.activation, lam)
        if colour != self._colour:
            self._colour = colour
            self._line.colors = np.array(colour, np.uint8)
        # The width is the second cue of λ: 3 px when the law is idle, 10 px when avoidance has full priority.
        self._line.thickness = round((3.0 + 7.0 * lam) * self._scale * 2.0) / 2.0
        x, y, z = ((a + b) / 2.0).tolist()
        self._label.position = (x, y, z + LABEL_ABOVE)
        self._label.text = f"d = {sample.distance * 1000.0:.0f} mm"

    def remove(self) -> None:
        for part in (self._line, *self._ends, self._label):
            part.remove()
