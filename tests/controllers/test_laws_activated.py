"""The laws whose avoidance comes and goes: activation in a hierarchy, the continuous inverse, set-based tasks."""
