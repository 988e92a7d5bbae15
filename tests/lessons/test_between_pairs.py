"""Lesson 10's step between two pairs: the bound fails with every other condition met, and a smooth distance cures it."""

from tests.lessons.test_lessons import values


def test_the_closest_pair_loses_more_than_100_mm_to_an_obstacle_at_rest() -> None:
    single, finer, smooth, soft, faster = values("limits", "tie", "margin")
    assert max(single, finer) < -0.1 and abs(finer - single) < 2e-3
    assert min(smooth, soft, faster) > 0.0
    assert values("limits", "tie", "approach") == (0.0,)
    assert values("limits", "tie", "authority") == (0.0,)
