"""Which settings matter in which experiment and under which law: the others are hidden, never removed."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, get_args

from app.settings import Settings
from scenes.settings import LawName, RunSettings, SceneName

TWO_ARMS: Final[frozenset[str]] = frozenset({"hold", "master_slave", "imitation"})
"""Experiments in which two arms meet."""

OBSTACLE: Final[frozenset[str]] = TWO_ARMS | {"ball"}
"""Experiments in which there is something to keep clear of."""

_SCENES: Final[frozenset[str]] = frozenset(get_args(SceneName))
_LAWS: Final[frozenset[str]] = frozenset(get_args(LawName))


@dataclass(frozen=True)
class When:
    """When a setting matters: in these experiments, under these laws, and if a further condition holds."""

    scenes: frozenset[str] = _SCENES
    laws: frozenset[str] = _LAWS
    also: Callable[[Settings], bool] | None = None


def both_avoid(run: RunSettings) -> bool:
    """Return whether both arms keep clear of each other."""
    if run.scene not in TWO_ARMS:
        return False
    return run.avoid == "both" or (run.avoid == "paper" and run.scene != "hold")


def _several_pairs(settings: Settings) -> bool:
    return settings.run.scene != "ball" or settings.run.point == "arm"


def _draws_circle(settings: Settings) -> bool:
    return settings.run.scene == "solo" and settings.run.path == "circle"


def _has_source(settings: Settings) -> bool:
    run = settings.run
    return not _draws_circle(settings) and not (run.scene == "ball" and run.ball == "still")


_ONE_ROW: Final = _LAWS - {"barrier_qp", "unprotected"}
"""Laws that see one distance."""

_ORDERED: Final = frozenset[str]({"smooth_priority", "intermediate_value", "continuous_inverse"})
"""Laws with the activation of eq. (31)."""

_RETREAT: Final = _ORDERED | {"strict_priority", "strict_switched", "null_space_avoidance", "task_activation"}
"""Laws that retreat at v."""

WHEN: Final[dict[str, When]] = {
    "robot": When(_SCENES - {"imitation"}),
    "rig": When(frozenset({"hold", "master_slave"})),
    "guided": When(frozenset({"hold", "master_slave"})),
    "avoid": When(TWO_ARMS),
    "task": When(frozenset({"solo", "ball", "hold"})),
    "start": When(frozenset({"hold"}), also=lambda s: s.run.rig == "torso" and s.run.robot == "lwr"),
    "path": When(frozenset({"solo"})),
    "kx": When(frozenset({"solo"})),
    "point": When(frozenset({"ball"})),
    "ball": When(frozenset({"ball"})),
    "following": When(frozenset({"master_slave"})),
    "source": When(frozenset({"imitation"})),
    "clip": When(frozenset({"imitation"}), also=lambda s: s.page.source == "clips"),
    "autopilot": When(also=_has_source),
    "gizmo": When(_SCENES - {"imitation"}, also=lambda s: not _draws_circle(s)),
    "seed": When(also=lambda s: _has_source(s) or s.run.hardware.joint_noise > 0.0 or s.run.hardware.distance_noise > 0.0),
    "wmax": When(_SCENES - {"imitation"}, also=lambda s: not _draws_circle(s)),
    "law": When(OBSTACLE),
    "dm": When(OBSTACLE, _LAWS - {"strict_priority", "potential_field", "unprotected"}),
    "n": When(OBSTACLE, _ORDERED),
    "v": When(OBSTACLE, _RETREAT),
    "d0": When(OBSTACLE, frozenset({"null_space_avoidance", "potential_field", "task_activation"})),
    "eta": When(OBSTACLE, frozenset({"potential_field"})),
    "gamma": When(OBSTACLE, frozenset({"barrier_qp"})),
    "kr": When(OBSTACLE, frozenset({"set_based_task"})),
    "pairs": When(OBSTACLE, _ONE_ROW),
    "beta": When(OBSTACLE, _ONE_ROW, lambda s: s.run.law.pairs != "single" and _several_pairs(s)),
    "eps": When(OBSTACLE, _ONE_ROW, lambda s: s.run.law.pairs == "smooth"),
    "ff": When(OBSTACLE, frozenset({"smooth_priority", "barrier_qp", "set_based_task"})),
    "one_sided": When(OBSTACLE, frozenset({"smooth_priority"})),
    "coupled": When(TWO_ARMS, _LAWS - {"unprotected"}, lambda s: both_avoid(s.run)),
    "fps": When(OBSTACLE),
    "dnoise": When(OBSTACLE),
    "ghost": When(OBSTACLE),
    "whatif": When(OBSTACLE),
}
"""Key → when it matters; a key that is not here matters always."""


def matters(key: str, settings: Settings) -> bool:
    """Return whether a setting, named by its key, has any effect now."""
    when = WHEN.get(key)
    if when is None:
        return True
    run = settings.run
    if run.scene not in when.scenes or run.law.law not in when.laws:
        return False
    return when.also is None or when.also(settings)


def built_of(settings: Settings) -> tuple[object, ...]:
    """Return what room, arms, handles and page are made of: where another one is chosen, something of them is built again."""
    run, page = settings.run, settings.page
    return (
        *(run.scene, run.robot, run.rig, run.point, run.guided, run.path, run.start),
        *(page.language, page.theme, page.profile, page.picture, page.ghost, page.details, page.source, page.gizmo),
    )
