"""The paper's law, eqs (12), (13), (26)–(33)."""

from dataclasses import dataclass

from controllers.laws.row_law import BlendLaw


@dataclass(frozen=True)
class SmoothPriority(BlendLaw):
    """q̇ = J_d^# λ(d) v + N' q̇_n with N' = I − λ(d) J_d^# J_d, eqs (32), (33), and q̇_n = J^# ẋ_c.

    As J_d is one row, eq. (32) is the same as

        q̇ = q̇_n + J_d^# λ (v + u),      u = −J_d q̇_n,

    a blend of two speeds along the line of contact: J_d q̇ = λ v − (1 − λ) u.

    Attributes:
        feed_forward: ours: add the obstacle's approach speed w to v, so that d ≥ d_m no longer needs w ≤ v.
        one_sided: ours: never slow down a retreat faster than v.
    """

    feed_forward: bool = False
    one_sided: bool = False

    def correction(self, distance: float, pull: float, approach: float) -> float:
        wanted = self.nominal_velocity + pull
        if self.feed_forward:
            wanted += approach
        if self.one_sided and wanted < 0.0:
            return 0.0
        return self.activation(distance) * wanted
