"""Random tasks whose M is to be looked at."""

import numpy as np
from hypothesis import strategies as st

from controllers.kinematics import Array
from controllers.stability import Analysis

SEEDS = st.integers(0, 10_000)
SHARES = st.floats(0.0, 1.0)
GAINS = st.floats(0.1, 20.0)
DIMENSIONS = st.sampled_from([1, 2, 3, 6])


def tasks(seed: int, m: int, n: int = 7) -> tuple[Array, Array]:
    """A random J_d (n,) and J_b (m, n)."""
    random = np.random.default_rng(seed)
    return random.normal(size=n) * 0.4, random.normal(size=(m, n)) * 0.4


def sym(matrix: Array) -> Array:
    return np.asarray(0.5 * (matrix + matrix.T), np.float64)


def in_metric(analysis: Analysis, row: Array, J_b: Array) -> Array:
    """M with e_a in units of |J_d| and e_b in the metric e_bᵀ (J_b J_bᵀ)⁻¹ e_b."""
    scale = np.zeros_like(analysis.M)
    scale[0, 0] = np.linalg.norm(row)
    scale[1:, 1:] = np.linalg.cholesky(J_b @ J_b.T)
    return np.asarray(np.linalg.solve(scale, analysis.M @ scale), np.float64)
