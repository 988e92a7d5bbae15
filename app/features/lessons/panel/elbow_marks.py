"""Marks for the elbow to touch."""

from collections.abc import Callable
from typing import Final

import numpy as np
import viser

from app.features.lessons.lesson import Step
from app.features.lessons.session.lesson_session import LessonSession
from app.features.measures.evidence import Evidence
from app.features.measures.quantities.quantity import measure, shown_parameter
from app.features.measures.room_places import mark_places
from app.session.frame import Frame
from app.settings import PageSettings
from app.stage.stage_part import fresh
from app.theme import PALETTES, rgb, scale
from scenes.simulation import Simulation

RADIUS: Final = 0.03
"""Drawn radius [m]; the challenge has its own tolerance."""

USUAL_REACH: Final = 0.015
"""Tolerance without a challenge [m]."""

PERIOD: Final = 0.2
"""Wall time between updates [s]."""


class Marks:
    """The marks of a step."""

    def __init__(self, scene: viser.SceneApi, run: LessonSession, page: Callable[[], PageSettings]) -> None:
        self._scene, self._run, self._page = scene, run, page
        self._nodes: list[tuple[viser.IcosphereHandle, viser.LabelHandle]] = []
        self._drawn: tuple[object, ...] | None = None
        self._next = 0.0

    def show(self, frame: Frame) -> None:
        step = self._run.walk.step if self._run.open and self._run.walk.step.marks else None
        page = self._page()
        drawn = None if step is None else (step, id(frame.live.simulation.room), page.theme, page.profile)
        if drawn != self._drawn:
            self._drawn = drawn
            for ball, label in self._nodes:
                ball.remove()
                label.remove()
            self._nodes.clear()
            if step is not None:
                self._draw(frame.live.simulation)
        if step is None or frame.now < self._next:
            return
        self._next = frame.after(PERIOD)
        for i, (angle, reach) in enumerate(zip(step.marks, reaches(step), strict=True)):
            miss = measure(Evidence(frame.live.simulation), "mark_miss", (("angle", angle),))
            self._paint(i, miss is not None and miss <= reach)

    def _draw(self, simulation: Simulation) -> None:
        larger = scale(self._page().profile)
        for i, place in enumerate(mark_places(simulation.room, self._run.walk.step.marks)):
            ball = self._scene.add_icosphere(
                f"/marks/{i + 1}",
                radius=RADIUS,
                subdivisions=3,
                position=place,
                cast_shadow=False,
                receive_shadow=False,
            )
            # The elbow is inside the arm, so the label is outside it.
            label = self._scene.add_label(
                f"/marks/label{i + 1}",
                "",
                position=place + np.array([0.0, 0.0, 0.11]),
                anchor="bottom-center",
            )
            label.font_screen_scale = 1.15 * larger
            self._nodes.append((fresh(ball), label))
            self._paint(i, False)

    def _paint(self, index: int, touched: bool) -> None:
        theme, (ball, label) = self._page().theme, self._nodes[index]
        # The arm is orange, so the marks are not.
        ball.color = rgb(PALETTES[theme].velocity if touched else PALETTES[theme].ink)
        angle = shown_parameter("angle", self._run.walk.step.marks[index])
        label.text = f"✓ {angle}" if touched else angle


def reaches(step: Step) -> tuple[float, ...]:
    """Tolerance at each mark [m]."""
    criteria = step.challenge.criteria if step.challenge is not None else ()
    said: dict[object, float] = {}
    for criterion in criteria:
        m = criterion.measurement
        if m.name == "mark_miss" and criterion.high is not None:
            said[dict(m.parameters)["angle"]] = criterion.high
    return tuple(said.get(angle, USUAL_REACH) for angle in step.marks)
