"""Recomputes a recorded piece of a run, also with other settings or finer steps."""

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import reduce
from typing import Final, cast

import pinocchio as pin

from controllers.compiled import load_now
from controllers.errors import BadSetting, LazyText
from controllers.kinematics import Array
from scenes.headless import Summary, summarise
from scenes.history import COLUMN
from scenes.inputs import Recorded, Stretch, merged_stretches
from scenes.law_answers import ReplayedLaw
from scenes.settings import (
    HardwareSettings,
    LawSettings,
    RunSettings,
    changed,
    leaves,
    replaced,
    specs,
    values,
)
from scenes.simulation import Simulation
from scenes.targets import AnglesTarget, HandTarget, HeldTarget, LinkTarget, PairTarget, Target, WallTarget
from scenes.wanted import while_wanted

FIXED: Final = frozenset({"scene", "rig", "robot", "guided", "path", "point", "dt"})
"""Settings of a recorded piece that set the room, the roles and the clock."""

WHAT_IF_KEYS: Final = (*specs(LawSettings), *specs(HardwareSettings), "k", "kx")

LOOK: Final = 64
"""Steps between two checks of `scenes.wanted`."""


@dataclass(frozen=True)
class Rerun:
    """A recomputed piece of a run.

    Attributes:
        table: (steps, columns of `scenes.history`).
        seams: rows at which the settings or the kind of target change.
    """

    table: Array
    summary: Summary
    seams: tuple[int, ...]


@dataclass(frozen=True)
class WhatIf:
    """A recorded piece, recomputed with other settings.

    Attributes:
        times: (k,) on the clock of the run [s].
        distance: d (k,) [m].
        squared_error: e² (k,) of the recorded task [m² or rad²].
        settings: at the end of the piece.
        before: summary of the original run over the same time.
    """

    times: Array
    distance: Array
    squared_error: Array
    settings: RunSettings
    summary: Summary
    before: Summary

    @property
    def seconds(self) -> float:
        return float(self.times[-1] - self.times[0])


def not_again(law: str) -> LazyText:
    return LazyText(
        "{law} runs in its own process, so this run cannot be computed again. The table and the pictures are available.",
        law=law,
    )


def begun(recorded: Recorded, capacity: int = 1) -> Simulation:
    """Simulation at the beginning of a recorded piece; a custom law repeats its recorded answers.

    The caller applies the settings of further stretches.
    """
    simulation = Simulation(recorded.settings, capacity)
    if recorded.law is not None:
        answers = [stretch.answers for stretch in recorded.stretches if stretch.answers is not None]
        simulation.use(ReplayedLaw(answers, simulation, recorded.snapshot.steps))
    simulation.resume(recorded.snapshot)
    return simulation


def rerun(recorded: Recorded, overrides: Mapping[str, object] | None = None, substeps: int = 1) -> Rerun:
    """Recompute a recorded piece; without other arguments the result equals the run bit for bit.

    Args:
        overrides: settings by key, in force all the time.
        substeps: parts of each step; the target then moves straight between recorded places.

    Raises:
        BadSetting: `substeps` < 1; an override is unknown, impossible or in `FIXED`; or overrides or substeps
            for a custom law.
        Stopped: see `scenes.wanted`.
    """
    if substeps < 1:
        raise BadSetting("substeps = {substeps} is too small; give a whole number from 1.", substeps=substeps)
    if recorded.law is not None and (overrides or substeps > 1):
        raise BadSetting(not_again(recorded.law.file))
    stretches = _stretches(recorded, overrides or {})
    rows = sum(stretch.targets.steps * substeps for stretch in stretches)
    simulation = begun(replace(recorded, stretches=stretches), rows)
    seams: list[int] = []
    wishes = [target for stretch in stretches for target in stretch.targets.each()]
    following = while_wanted(zip(wishes, [*wishes[1:], wishes[-1]], strict=True), LOOK)
    before: object = None
    for stretch in stretches:
        simulation.apply(replace(stretch.settings, dt=stretch.settings.dt / substeps))
        for i, (target, after) in enumerate(itertools.islice(following, stretch.targets.steps)):
            kind = _kind(target)
            if simulation.history.count and (i == 0 or kind != before):
                seams.append(simulation.history.count)
            before = kind
            simulation.step(target)
            for part in range(1, substeps):
                simulation.step(target_between(target, after, part / substeps))
    table = simulation.history.table()
    return Rerun(table, summarise(simulation, table), tuple(seams))


def newest_steps(recorded: Recorded, seconds: float) -> int:
    kept, left = 0, seconds
    for settings, targets, _ in reversed(recorded.stretches):
        steps = min(targets.steps, int(left / settings.dt + 1e-6)) if math.isfinite(left) else targets.steps
        kept, left = kept + steps, left - steps * settings.dt
        if steps < targets.steps:
            break
    return max(kept, 1)


def newest_piece(recorded: Recorded, seconds: float) -> Recorded:
    """The last `seconds` of a piece; earlier steps are recomputed for its first state.

    Raises:
        Stopped: see `rerun`.
    """
    ahead = recorded.steps - newest_steps(recorded, seconds)
    if not ahead:
        return recorded
    simulation = begun(recorded)
    for i, stretch in enumerate(recorded.stretches):
        simulation.apply(stretch.settings)
        for target in while_wanted(itertools.islice(stretch.targets.each(), ahead), LOOK):
            simulation.step(target)
        if ahead < stretch.targets.steps:
            return Recorded(simulation.snapshot(), (stretch.since(ahead), *recorded.stretches[i + 1 :]))
        ahead -= stretch.targets.steps
    raise AssertionError("a piece has at least one step")


def what_if(recorded: Recorded, overrides: Mapping[str, object], before: Summary) -> WhatIf:
    """Recompute a recorded piece with other settings.

    Raises:
        BadSetting, Stopped: as `rerun`.
    """
    again = rerun(recorded, overrides)
    times, distance, squared_error = (again.table[:, COLUMN[name]].copy() for name in ("t", "d", "e2"))
    settings = _stretches(recorded, overrides)[-1].settings
    return WhatIf(times, distance, squared_error, settings, again.summary, before)


def warm(settings: RunSettings) -> None:
    """Load machine code in a few steps, so that the first real step is fast."""
    load_now()
    simulation = Simulation(settings, 16)
    source = simulation.source()
    for _ in while_wanted(range(16)):
        simulation.step(source.target(simulation.time))


def _stretches(recorded: Recorded, overrides: Mapping[str, object]) -> tuple[Stretch, ...]:
    if not overrides:
        return recorded.stretches
    checked = recorded.settings
    for key, value in overrides.items():
        if key in FIXED:
            fixed = ", ".join(sorted(FIXED))
            raise BadSetting(
                "{key} cannot be given to a recorded run, of which {fixed} are fixed.", key=key, fixed=fixed
            )
        checked = changed(checked, key, value)
    wanted = [
        (leaves(RunSettings)[key][0], value) for key, value in values(checked).items() if key in overrides
    ]

    def overridden(settings: RunSettings) -> RunSettings:
        for path, value in wanted:
            if reduce(getattr, path, settings) != value:
                settings = replaced(settings, path, value)
        return settings

    return merged_stretches([Stretch(overridden(s.settings), s.targets) for s in recorded.stretches])


def _kind(target: Target | None) -> object:
    if isinstance(target, HandTarget):
        return HandTarget, target.rotation is None, target.elbow is None
    if isinstance(target, AnglesTarget):
        return AnglesTarget, target.angles is None
    if isinstance(target, LinkTarget):
        return LinkTarget, target.joint, tuple(target.offset.tolist())
    return type(target)


def target_between(first: Target | None, second: Target | None, share: float) -> Target | None:
    """Target at a share of the way between two of one kind; the first one if the kinds differ."""
    if isinstance(first, PairTarget) and isinstance(second, PairTarget):
        of_first, of_second = (
            target_between(first.first, second.first, share),
            target_between(first.second, second.second, share),
        )
        return PairTarget(cast(HeldTarget | WallTarget | None, of_first), cast(HeldTarget, of_second))
    if (
        first is second
        or first is None
        or second is None
        or first[0] is None
        or _kind(first) != _kind(second)
    ):
        return first
    if isinstance(first, HandTarget):
        assert isinstance(second, HandTarget)
        rotation = elbow = None
        if first.rotation is not None and second.rotation is not None:
            rotation = first.rotation @ pin.exp3(share * pin.log3(first.rotation.T @ second.rotation))
        if first.elbow is not None and second.elbow is not None:
            elbow = _part(first.elbow, second.elbow, share)
        return HandTarget(_part(first.position, second.position, share), rotation, elbow)
    if isinstance(first, WallTarget):
        assert isinstance(second, WallTarget)
        return WallTarget(
            _part(first.position, second.position, share), _part(first.turn, second.turn, share)
        )
    if isinstance(first, LinkTarget):
        assert isinstance(second, LinkTarget)
        return first._replace(position=_part(first.position, second.position, share))
    assert not isinstance(first, PairTarget)
    # All others consist of one array.
    return type(first)(_part(first[0], second[0], share))  # pyright: ignore[reportArgumentType]


def _part(first: Array, second: Array, share: float) -> Array:
    return first + share * (second - first)
