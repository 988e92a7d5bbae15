"""Settings that matter; the others are hidden, never removed."""

from collections.abc import Callable
from typing import Final

from app.settings import Settings
from scenes.experiments import EXPERIMENTS
from scenes.quantities import ALL, DISTANCE, PARTS, TIP, WALL
from scenes.settings import LawSettings, RunSettings, specs


def _can_be_pulled(settings: Settings) -> bool:
    return settings.run.experiment.moves != "person" and not settings.run.draws_circle


def _seen_together(run: RunSettings) -> bool:
    """True if one row can be made of several: of pairs of bodies, or of first tasks without a stage."""
    return run.quantity is DISTANCE or (run.quantity.name in PARTS and run.together == "ratios")


def _something_comes(run: RunSettings) -> bool:
    """True if w can differ from 0: of all first tasks, only a wall comes."""
    return run.quantity is DISTANCE or WALL in PARTS.get(run.quantity.name, (run.quantity.name,))


_OF_LAWS: Final = frozenset(specs(LawSettings)) - {"law"}

_OF_OBSTACLES: Final = _OF_LAWS | {"law", "fps", "dnoise", "ghost", "whatif"}

ALSO: Final[dict[str, Callable[[Settings], bool]]] = {
    "avoid": lambda s: s.run.experiment.obstacle == "arm",
    "start": lambda s: s.run.fits_between,
    "source": lambda s: s.run.experiment.moves == "person",
    "clip": lambda s: s.page.source == "clips",
    "autopilot": lambda s: s.run.moves_itself,
    "gizmo": _can_be_pulled,
    "seed": lambda s: (
        s.run.moves_itself or s.run.hardware.joint_noise > 0.0 or s.run.hardware.distance_noise > 0.0
    ),
    "wmax": _can_be_pulled,
    # A point of the arm and the ball are one pair.
    "beta": lambda s: (
        s.run.law.pairs != "single"
        and (s.run.point == "arm" or "point" not in s.run.experiment.reads)
        and _seen_together(s.run)
    ),
    "eps": lambda s: s.run.law.pairs == "smooth" and s.run.quantity is DISTANCE,
    "pairs": lambda s: _seen_together(s.run),
    "ff": lambda s: _something_comes(s.run),
    "together": lambda s: s.run.first == ALL,
    "load": lambda s: s.run.first in (TIP, ALL),
    "coupled": lambda s: s.run.both_avoid and not s.run.law.knows_w,
}


def matters(key: str, settings: Settings) -> bool:
    run, experiment = settings.run, settings.run.experiment
    if key not in experiment.reads and any(key in other.reads for other in EXPERIMENTS.values()):
        return False
    if key in _OF_OBSTACLES and experiment.obstacle == "nothing":
        return False
    if key in _OF_LAWS and key not in run.law.entry.settings:
        return False
    return key not in ALSO or ALSO[key](settings)


def built_of(settings: Settings) -> tuple[object, ...]:
    """Settings whose change rebuilds room, arms, handles or page."""
    run, page = settings.run, settings.page
    return (
        *(
            run.scene,
            run.robot,
            run.rig,
            run.point,
            run.guided,
            run.path,
            run.start,
            run.first,
            run.load,
            run.together,
        ),
        *(
            page.language,
            page.theme,
            page.profile,
            page.picture,
            page.ghost,
            page.details,
            page.source,
            page.gizmo,
        ),
    )
