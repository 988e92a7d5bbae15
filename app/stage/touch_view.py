"""Light and word where an arm or ball touches its surroundings."""

from itertools import zip_longest
from typing import Final

import numpy as np
import viser

from app.i18n.speaking import N_, tr
from app.session.frame import Frame
from app.settings import PageSettings
from app.stage.contact_view import LABEL_SCALE, label_size
from app.stage.stage_part import StagePart
from app.theme import PALETTES, rgb, scale
from scenes.world_stages import Thing

MOST: Final = 2

RADIUS: Final = 0.022
"""Radius of a light [m]."""

BELOW: Final = 0.03
"""Height of the light above the word [m]."""

WORDS: Final[dict[Thing, str]] = {
    "table": N_("touches the table"),
    "floor": N_("touches the floor"),
    "stand": N_("touches the stand"),
    "pedestal": N_("touches the pedestal"),
    "itself": N_("touches itself"),
}


class TouchedPoints(StagePart):
    """Visible while the arms keep clear of their surroundings and are near them."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._lights = [
            scene.add_icosphere(
                f"/touch/light{i}", radius=RADIUS, subdivisions=2, cast_shadow=False, visible=False
            )
            for i in range(MOST)
        ]
        self._labels = [
            scene.add_label(f"/touch/thing{i}", "", anchor="top-center", visible=False) for i in range(MOST)
        ]
        self.nodes = (*self._lights, *self._labels)

    def dress(self, page: PageSettings) -> None:
        self._scale = scale(page.profile)
        for light, label in zip(self._lights, self._labels, strict=True):
            light.color = rgb(PALETTES[page.theme].warning)
            label.font_screen_scale = LABEL_SCALE * self._scale

    def show(self, frame: Frame) -> None:
        stages = frame.simulation.stages
        touches = stages.touches() if stages is not None else ()
        for light, label, touch in zip_longest(self._lights, self._labels, touches[:MOST]):
            light.visible = label.visible = touch is not None
            if touch is None:
                continue
            light.position = touch.point
            label.text = tr(WORDS[touch.thing])
            place = touch.point - np.array([0.0, 0.0, BELOW])
            if self.keep_free is not None:
                place, _ = self.keep_free(place, label_size(label.text, self._scale))
            label.position = place
