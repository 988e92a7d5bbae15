"""The names of what can be chosen of the methods; importing them loads no library."""

from typing import Literal

BoundsTreatment = Literal["distance", "scale", "null_space"]
"""How bounds are met: by keeping the distance rate; by shortening the whole velocity; or by saturation in the null space."""

Treatment = Literal["single", "soft", "smooth"]
"""What the law sees of the pairs: the closest one (the paper), a smooth minimum over all (ours), or a smooth minimum over distances
that are smooth themselves (ours, `controllers.convex_distance`)."""

HandTask = Literal["position", "pose"]
"""What the hand keeps: where it is (3 dimensions), or also how it is turned (6)."""
