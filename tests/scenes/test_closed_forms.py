"""The whole loop with the real arms against line (R), ḋ = λ v − (1 − λ) u − w, and what it says in closed form.

Pull u and approach w along the line of contact are made constant: the avoiding arm's task is −u along its row, the other arm comes
with w along its own. Everything else (poses, capsules, rows, the law, the integration) is what the product runs.
"""

import numpy as np
import pytest

from controllers import budget
from controllers.choices import Treatment
from controllers.kinematics import Array, Kinematics
from controllers.laws.situation import AUTHORITY, Situation
from controllers.laws.smooth_priority import SmoothPriority
from controllers.limits import Authority
from controllers.proximity import ProximityDetector
from scenes.room import build_room
from scenes.settings import RigName
from tests.scenes.helpers import RIG_NAMES, column, hold_run, hold_settings


class Contact:
    """Two real arms and one pair of bodies that does not change; left avoids, right comes."""

    def __init__(self, rig: RigName, law: SmoothPriority, first: str = "hand", second: str = "forearm") -> None:
        self.room, self.law = build_room(rig), law
        self.kinematics = Kinematics(self.room.model, self.room.arms)
        self.detector = ProximityDetector(self.kinematics, self.room.geometry)
        self.pair = self.detector.pair_names.index((f"left {first}", f"right {second}"))
        self.left, self.right = self.room.arms[0].joints, self.room.arms[1].joints
        self.q = self.room.start.copy()
        self.row = np.zeros(self.room.model.nv)

    def measure(self) -> float:
        self.kinematics.update(self.q)
        self.detector.detect()
        self.row = self.detector.row(self.pair)
        for joints in (self.left, self.right):
            assert np.linalg.norm(self.row[joints]) > AUTHORITY
        return float(self.detector.distances()[self.pair])

    def along(self, joints: slice, speed: float) -> Array:
        """The smallest velocity (7,) of an arm that changes d at a speed [m/s]."""
        row = self.row[joints]
        return row * (speed / row.dot(row))

    def start_at(self, distance: float) -> None:
        for _ in range(100):
            missing = distance - self.measure()
            step = float(np.clip(missing, -0.02, 0.02)) / 2.0
            self.q[self.left] += self.along(self.left, step)
            self.q[self.right] += self.along(self.right, step)
            if abs(missing) < 1e-12:
                break
        assert self.measure() == pytest.approx(distance, abs=1e-9)

    def avoiding(self, joints: slice, distance: float, pull: float, approach: float, aside: float) -> Array:
        """What the law makes of a task that pulls with u, and wanders aside of the row."""
        row = self.row[joints]
        wander = aside * np.cos(np.arange(7.0))
        nominal = self.along(joints, -pull) + wander - self.along(joints, float(row @ wander))
        return self.law(Situation(self.q[joints], nominal, row, distance, approach))

    def run(
        self, steps: int, dt: float, pull: float, approach: float = 0.0, aside: float = 0.0, both: float | None = None
    ) -> Array:
        """Return d (steps + 1,) while the left arm avoids and the right one comes with w, or avoids a pull of its own."""
        path = [self.measure()]
        for _ in range(steps):
            left, right = self.avoiding(self.left, path[-1], pull, approach, aside), self.along(self.right, -approach)
            if both is not None:
                right = self.avoiding(self.right, path[-1], both, 0.0, 0.0)
            self.q[self.left] += left * dt
            self.q[self.right] += right * dt
            path.append(self.measure())
        return np.array(path)


DM, V = 0.15, 0.3


def contact_at(rig: RigName, distance: float, n: float, v: float = V, dm: float = DM, fed: bool = False) -> Contact:
    contact = Contact(rig, SmoothPriority(dm, n, v, feed_forward=fed))
    contact.start_at(distance)
    return contact


STILL = [(n, u, 0.0) for n, u in ((2.0, 0.2), (6.0, 0.05), (6.0, 0.2), (10.0, 0.2), (20.0, 0.4))]
COMING = [(6.0, 0.1, 0.1), (10.0, 0.0, 0.2), (10.0, 0.2, 0.25), (20.0, -0.05, 0.15)]


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize(("n", "u", "w"), STILL + COMING)
def test_the_arm_comes_to_rest_at_the_closed_form_from_either_side(rig: RigName, n: float, u: float, w: float) -> None:
    """Within 1 mm of d*; against an obstacle that comes with w ≤ v, from further away d never falls below d_m."""
    rest, tau = budget.resting_distance(DM, n, V, u, w), budget.settling_time(DM, n, V, u, w)
    dt = min(0.1 * tau, 0.005 if w else 0.02)
    for start in (rest + 0.01,) if w else (rest - 0.02, rest + 0.02):
        path = contact_at(rig, start, n).run(round(5.0 * tau / dt), dt, u, w)
        assert path[-1] == pytest.approx(rest, abs=1e-3)
        assert not w or path.min() >= DM


@pytest.mark.parametrize("rig", RIG_NAMES)
def test_motion_aside_and_fed_forward(rig: RigName) -> None:
    # A task that also wanders across the row, even quickly, rests at the same d*: the joints themselves do go elsewhere.
    n, u = 10.0, 0.2
    rest, tau = budget.resting_distance(DM, n, V, u), budget.settling_time(DM, n, V, u)
    ends = []
    for aside in (0.0, 0.3):
        contact = contact_at(rig, rest + 0.01, n)
        assert contact.run(round(5.0 * tau / 0.001), 0.001, u, aside=aside)[-1] == pytest.approx(rest, abs=1e-3)
        ends.append(contact.q)
    assert np.abs(ends[1] - ends[0]).max() > 0.05
    # With w fed forward, line (R) holds with v + w for v: d ≥ d_m at w = 2 v, where the plain law loses (positive control).
    u, w = 0.1, 0.6
    fed, plain = (contact_at(rig, 0.16, n, fed=fed).run(300, 0.0005, u, w) for fed in (True, False))
    assert fed.min() >= DM > plain.min()
    assert fed[-1] == pytest.approx(budget.resting_distance(DM, n, V + w, u, w), abs=1e-3)


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize(("u", "w"), [(0.2, 0.28), (0.2, 0.30), (0.2, 0.32), (-0.1, 0.45), (1.0, 0.45)])
def test_a_faster_obstacle_wins_by_exactly_the_difference(rig: RigName, u: float, w: float) -> None:
    """d_m is kept if and only if w ≤ v; below d_m the distance falls at w − v whatever u, within 1 mm/s."""
    assert bool(contact_at(rig, 0.16, 10.0).run(300, 0.001, u, w).min() >= DM - 1e-4) is budget.holds_distance(V, w) is (w <= V)
    if w > V:
        path = contact_at(rig, 0.14, 6.0).run(300, 0.0005, u, w)
        assert np.abs(np.diff(path) / 0.0005 + (w - V)).max() < 1e-3


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize(("v", "pulls"), [(0.05, (0.2, 0.3)), (0.3, (0.2, 0.2)), (0.3, (0.4, -0.1))])
def test_both_arms(rig: RigName, v: float, pulls: tuple[float, float]) -> None:
    """If both arms avoid, d never passes d_m for any v > 0, and each step's rate is 2 λ v − (1 − λ)(u_L + u_R)."""
    n, dt = 10.0, 0.001
    path = contact_at(rig, 0.17, n, v).run(500, dt, pulls[0], both=pulls[1])
    assert path.min() >= DM
    expected = [budget.distance_rate_both(x, v, *pulls) for x in np.minimum(1.0, (DM / path[:-1]) ** n)]
    assert np.abs(np.diff(path) / dt - expected).max() < 1e-3


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize(("n", "u"), [(10.0, 0.2), (20.0, 0.4)])
def test_explicit_euler_breaks_where_the_budget_says(rig: RigName, n: float, u: float) -> None:
    """Around d*, half a millimetre off dies out at .93 of `largest_step_at_rest`, and swings for ever at 1.07 of it."""
    rest, limit = budget.resting_distance(DM, n, V, u), budget.largest_step_at_rest(DM, n, V, u)
    quiet, swinging = (contact_at(rig, rest + 5e-4, n).run(120, share * limit, u)[-10:] for share in (0.93, 1.07))
    assert np.ptp(quiet) < 1e-4
    assert np.ptp(swinging) > 2e-3
    changes = np.sign(np.diff(swinging))
    assert (changes[1:] * changes[:-1] < 0.0).all()


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("pairs", ["single", "soft"])
def test_the_line_holds_along_a_hold_run(rig: RigName, pairs: Treatment) -> None:
    """Step by step of a whole run with the real task and person: Δd/dt = λ v − (1 − λ) u − w within 1 mm/s.

    Where it is promised, that is: no limit acts, J_d is not singular, and (single) the closest pair stays the same.
    """
    dt = 0.0025
    run = hold_run(rig, 1, pairs, dt=dt, seconds=20.0)
    table, settings = run.table, hold_settings(rig, 1, pairs, dt=dt)
    room = build_room(rig)
    kinematics = Kinematics(room.model, room.arms)
    detector = ProximityDetector(kinematics, room.geometry)
    positions, compared, worst, active = run.simulation.history.positions(table), 0, 0.0, 0.0
    for k in range(0, len(table) - 1, 4):
        same = pairs == "soft" or column(table, "pair")[k] == column(table, "pair")[k + 1]
        kinematics.update(positions[k])
        row = detector.detect(pairs, settings.law.beta).row[room.arm("left").joints]
        if not same or column(table, "authority")[k] != Authority.FULL or np.linalg.norm(row) < AUTHORITY:
            continue
        lam, u, w = (float(column(table, name)[k]) for name in ("lambda", "u", "w_law"))
        rate = float(column(table, "law_d")[k + 1] - column(table, "law_d")[k]) / dt
        worst = max(worst, abs(rate - budget.distance_rate(lam, settings.law.nominal_velocity, u, w)))
        compared, active = compared + 1, max(active, lam)
    assert compared > 0.3 * len(table) / 4
    assert active > 0.5
    assert worst < 1.2e-3
