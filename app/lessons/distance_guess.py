"""A guess of d on the axis of the line of contact: where a lesson asks for a distance, it decides between the answers."""

import math
from typing import Final

from app.lessons.lesson import Step
from scenes.settings import values

BEYOND_CRITICAL: Final = {"distance_at": False, "smallest_distance": False, "distance_margin": True}
"""Names of the measurements that are a distance → whether it is d − d_m instead of d."""

FARTHEST: Final = 1.0
"""Largest |d| that can be guessed [m]."""


def asks_for_distance(step: Step) -> bool:
    """Return whether a step's answers differ by one distance."""
    question = step.question
    if question is None or question.ratio or step.drawing is not None or not question.expects:
        return False
    return step.measurements[0].name in BEYOND_CRITICAL and len(set(question.expects)) == len(question.expects)


def guessed_answer(step: Step, distance: float) -> int | None:
    """Return the index of the answer that a distance [m] speaks for; None if it speaks for none, or the step asks for no distance."""
    if step.question is None or not asks_for_distance(step) or not math.isfinite(distance) or abs(distance) > FARTHEST:
        return None
    from_critical = BEYOND_CRITICAL[step.measurements[0].name]
    critical = float(values(step.setup.run)["dm"])
    return step.question.supported(distance - critical if from_critical else distance)
