"""Names of the selectable methods; importing them loads no library."""

from typing import Literal

BoundsTreatment = Literal["distance", "scale", "null_space"]
"""Treatment of bounds: keep the distance rate; shorten the whole velocity; saturate in the null space."""

Treatment = Literal["single", "soft", "smooth"]
"""Pairs that the law sees: the closest one (the paper), a smooth minimum over all (ours), or a smooth minimum
over smooth distances (ours, `controllers.convex_distance`).
"""

HandTask = Literal["position", "pose"]
"""Task of the hand: position (3 dimensions), or also orientation (6)."""
