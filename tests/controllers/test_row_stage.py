"""Stages: each result is within the bounds, the last stage wins, and a law uses only h and J_a."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from controllers.activation import activation
from controllers.first_tasks.first_task import FirstTask, Margin
from controllers.kinematics import Array
from controllers.laws.smooth_priority import SmoothPriority
from controllers.limits import Authority, VelocityBox
from controllers.row_stage import RowStage, smooth_stage, through_stages


class Told(FirstTask):
    """First task with a given margin."""

    name, unit = "given", "m"

    def __init__(
        self, margin: Margin, critical_value: float, nominal_rate: float, authority: float = 0.12
    ) -> None:
        super().__init__(critical_value, nominal_rate)
        self._margin, self.authority = margin, authority

    def margin(self) -> Margin:
        return self._margin


def box(top: float, positions: Array | None = None) -> VelocityBox:
    wide = np.full(4, 10.0)
    made = VelocityBox(-wide, wide, np.full(4, top), 10.0)
    made.update(np.zeros(4) if positions is None else positions)
    return made


ROWS = np.array([[0.5, -0.3, 0.2, 0.1], [0.4, 0.3, 0.0, -0.2]])
NOMINAL = np.array([0.3, -0.2, 0.1, 0.4])


def test_eq_32_with_its_projector() -> None:
    row, w = ROWS[0], 0.07
    stage = smooth_stage(Told(Margin(0.18, row, w), 0.15, 0.3), box(5.0), 4.0)
    lam = activation(0.18, 0.15, 4.0)
    sharp = row / (row @ row)
    expected = sharp * (lam * 0.3) + (np.eye(4) - lam * np.outer(sharp, row)) @ NOMINAL
    assert_allclose(stage(NOMINAL), expected, atol=1e-15)


def test_a_change_of_unit_changes_nothing() -> None:
    """In millimetres h, h_m, v, J_a, w and the authority are a thousand times as large."""
    weak = 0.1 * ROWS[0]
    metres = smooth_stage(Told(Margin(0.16, weak, 0.01), 0.15, 0.3), box(5.0))
    millimetres = smooth_stage(
        Told(Margin(160.0, 1000.0 * weak, 10.0), 150.0, 300.0, authority=120.0), box(5.0)
    )
    assert_allclose(millimetres(NOMINAL), metres(NOMINAL), rtol=1e-12)
    assert not np.allclose(metres(NOMINAL), NOMINAL)


def test_the_last_stage_has_its_rate_and_changes_the_first_one_s() -> None:
    margins = [Margin(0.14, ROWS[0]), Margin(0.02, ROWS[1])]
    stages = [
        smooth_stage(Told(margins[0], 0.15, 0.3), box(9.0)),
        smooth_stage(Told(margins[1], 0.03, 0.05), box(9.0)),
    ]
    dq = through_stages(NOMINAL, stages)
    assert ROWS[1] @ dq == pytest.approx(0.05, abs=1e-12)
    before = stages[0](NOMINAL)
    assert ROWS[0] @ before == pytest.approx(0.3, abs=1e-12)
    assert ROWS[0] @ dq == pytest.approx(0.3 + float(ROWS[0] @ (dq - before)), abs=1e-12)
    assert abs(ROWS[0] @ dq - 0.3) > 1e-3


def test_every_stage_ends_within_the_bounds() -> None:
    limits = box(0.35)
    stages = [
        smooth_stage(Told(Margin(0.1, ROWS[0]), 0.15, 0.3), limits),
        smooth_stage(Told(Margin(0.02, ROWS[1]), 0.03, 0.1), limits),
    ]
    dq = NOMINAL * 0.5
    for stage in stages:
        dq = stage(dq)
        assert limits.contains(dq)
        assert stage.task.margin().row @ dq == pytest.approx(stage.task.nominal_rate, abs=1e-9)


def test_a_missing_authority_is_reported() -> None:
    stage = smooth_stage(Told(Margin(0.01, ROWS[0]), 0.03, 0.9), box(0.2))
    done = stage.bounded(np.zeros(4), stage.task.margin())
    assert done.authority is Authority.SPEED and stage.box.contains(done.velocities)


def test_one_sided_does_not_change_a_retreat() -> None:
    fast = 2.0 * ROWS[0]
    margin = Margin(0.02, ROWS[0])
    assert smooth_stage(Told(margin, 0.03, 0.0), box(5.0), one_sided=True)(fast) is fast
    assert not np.allclose(smooth_stage(Told(margin, 0.03, 0.0), box(5.0))(fast), fast)


def test_any_law_of_one_row_can_be_a_stage() -> None:
    law = SmoothPriority(0.15, 6.0, 0.3, feed_forward=True)
    margin = Margin(0.1, ROWS[0], 0.2)
    stage = RowStage(Told(margin, 0.15, 0.3), law, box(9.0))
    assert ROWS[0] @ stage(NOMINAL) - 0.2 == pytest.approx(0.3, abs=1e-12)
