"""My own law: what the avoiding arm does, 200 times a second.

    lwr-duet law-test my_law.py              six tests, each with its reason
    lwr-duet serve --law-file my_law.py      the page; save this file and the arm follows the new law

law(situation) gets what the arm knows in this tick and returns q̇, one velocity a joint [rad/s]. n is the number of joints, 7.

    situation.positions      q (n,) [rad]
    situation.nominal        q̇_n (n,), what the task asks for [rad/s]
    situation.row            J_d (n,): J_d @ q̇ is how fast the arm's own motion changes the distance, + is away [m/rad]
    situation.distance       d [m], negative in overlap, inf in an empty room
    situation.pull           u = −J_d @ q̇_n [m/s], how fast the task pulls towards the obstacle
    situation.approach       w [m/s], how fast the obstacle comes
    situation.task_jacobian  J (m, n) of the hand's task, or None if the task uses every joint
    situation.lower, .upper  bounds of q̇ (n,) [rad/s]
    situation.rows, .distances, .approaches   the same of every pair of bodies: (pairs, n), (pairs,), (pairs,); None in an empty room

If something goes wrong (an exception, nan, a wrong shape, an endless loop) the arm freezes and the page names the line.
What you print is not shown; `raise ValueError(x)` shows x. Keep nothing in mind between two calls: a ghost calls the law too.
"""

D_M = 0.15  # critical distance [m]: inside, avoidance has full priority
ORDER = 6.0  # n: larger is later and steeper
V = 0.30  # speed of retreat at full priority [m/s]
MU = 0.01  # damping of J_d^# [m/rad]: no division by zero where no joint moves the distance


def activation(distance):
    """λ(d), eq. (31) of the paper, from 0 to 1. The page draws it; leave it out if your law has no such thing."""
    return 1.0 if distance <= D_M else (D_M / distance) ** ORDER


def law(situation):
    """The paper's law, eqs (32), (33): q̇ = q̇_n + J_d^# λ (v + u), with J_d^# = J_dᵀ / (J_d J_dᵀ + μ²)."""
    lam = activation(situation.distance)
    c = lam * (V + situation.pull)  # what the distance rate is to change by [m/s]
    J_d = situation.row
    square = J_d @ J_d + MU**2  # Is that enough where J_d is nearly 0? One of the six tests asks.
    return situation.nominal + J_d * c / square
