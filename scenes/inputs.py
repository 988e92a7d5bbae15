"""Inputs of a run's steps, to recompute it exactly or with other settings."""

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby, islice
from operator import attrgetter
from typing import Final, NamedTuple

import numpy as np

from scenes.law_answers import LawAnswers, LawOfFile
from scenes.packing import WIDTHS, PackedTargets, decoded, encoded, joined_targets
from scenes.roles import Roles
from scenes.settings import RunSettings
from scenes.simulation import Simulation, Snapshot
from scenes.targets import Target

KEEP: Final = 600.0
"""Simulated time in a log [s]."""

MOST_BYTES: Final = 16_000_000
"""Above this, a log keeps less time [B]."""

CHAPTER: Final = 1.0
"""Simulated time between two snapshots [s]."""

_STRETCH_BYTES: Final = 1_000
_CHAPTER_BYTES: Final = 3_000
_OPEN_BYTES: Final = 120


class Stretch(NamedTuple):
    """Steps with the same settings. `answers`: of a custom law; None for the settings' law."""

    settings: RunSettings
    targets: PackedTargets
    answers: LawAnswers | None = None

    @property
    def seconds(self) -> float:
        """[s]"""
        return self.targets.steps * self.settings.dt

    @property
    def nbytes(self) -> int:
        """Approximate size [B]."""
        answers = 0 if self.answers is None else self.answers.rows.nbytes
        return _STRETCH_BYTES + sum(array.nbytes for array in self.targets) + answers

    def since(self, step: int) -> "Stretch":
        answers = None if self.answers is None else self.answers._replace(rows=self.answers.rows[step:])
        return Stretch(self.settings, self.targets.since(step), answers)


@dataclass(frozen=True)
class Recorded:
    """A recorded piece of a run, see `scenes.rerun`; picklable. `stretches`: at least one."""

    snapshot: Snapshot
    stretches: tuple[Stretch, ...]

    @property
    def settings(self) -> RunSettings:
        return self.stretches[0].settings

    @property
    def law(self) -> LawAnswers | None:
        """Newest answers of a custom law; None for the settings' law."""
        return self.stretches[-1].answers

    @property
    def begin(self) -> float:
        """Simulated time [s]."""
        return self.snapshot.time

    @property
    def steps(self) -> int:
        return sum(stretch.targets.steps for stretch in self.stretches)

    @property
    def seconds(self) -> float:
        """[s]"""
        return sum(stretch.seconds for stretch in self.stretches)

    @cached_property
    def nbytes(self) -> int:
        """Approximate size [B]."""
        return _CHAPTER_BYTES + sum(stretch.nbytes for stretch in self.stretches)

    def targets(self, simulation: Simulation | None = None) -> Iterator[Target | None]:
        """Target of every step. `simulation`: gets the settings of each step before its target."""
        for stretch in self.stretches:
            if simulation is not None:
                simulation.apply(stretch.settings)
            yield from stretch.targets.each()


class RecordedPerson:
    """A `TargetSource` of recorded targets; the last one remains."""

    def __init__(self, recorded: Recorded) -> None:
        self.recorded = recorded
        targets = joined_targets([stretch.targets for stretch in recorded.stretches])
        times = np.concatenate(
            [stretch.targets.counts * stretch.settings.dt for stretch in recorded.stretches]
        )
        self._targets, self._offsets, self._ends = targets, targets.offsets, np.cumsum(times)
        self._steps = np.cumsum(targets.counts, dtype=np.int64)

    def target(self, time: float) -> Target | None:
        """Target at a time since the beginning [s]."""
        # A sum of time steps may be slightly before its step.
        return self._different(
            min(int(np.searchsorted(self._ends, time + 1e-6, side="right")), len(self._ends) - 1)
        )

    def target_of_step(self, step: int) -> Target | None:
        return self._different(int(np.searchsorted(self._steps, step, side="right")))

    def _different(self, i: int) -> Target | None:
        code, begin = int(self._targets.codes[i]), int(self._offsets[i])
        return decoded(code, self._targets.numbers[begin : begin + WIDTHS[code]])


@dataclass(slots=True)
class _Wanted:
    """Equal targets and settings in consecutive steps; `code` and `numbers` as in `encoded`."""

    settings: RunSettings
    code: int
    numbers: bytes
    steps: int = 1


class InputsLog:
    """The newest `keep` seconds of a run, fewer above `most_bytes`, with a snapshot every second."""

    def __init__(self, keep: float = KEEP, most_bytes: int = MOST_BYTES) -> None:
        self._keep, self._most_bytes = keep, most_bytes
        self._chapters: deque[Recorded] = deque()
        self._roles: Roles | None = None
        self._law: LawOfFile | None = None
        self.forget()

    def forget(self) -> None:
        self._chapters.clear()
        self._expected = self._turn = -1
        """Steps before the next record, and before the next chapter."""
        self._snapshot: Snapshot | None = None
        """Beginning of the open chapter."""
        self._wanted: list[_Wanted] = []
        self._answers: list[bytes] = []
        """A custom law's answers in the open chapter."""

    @property
    def nbytes(self) -> int:
        """Approximate size [B]."""
        return (
            sum(chapter.nbytes for chapter in self._chapters)
            + (len(self._wanted) + len(self._answers)) * _OPEN_BYTES
        )

    def record(self, simulation: Simulation, target: Target | None) -> None:
        """Record the inputs of the next step, before it; restart the log after a reset, or with other roles
        or another custom law.
        """
        if not self._leads_to(simulation):
            self.forget()
            self._roles, self._law = simulation.roles, law_of_file(simulation)
        if simulation.steps >= self._turn:
            self._begin_chapter(simulation)
        settings, (code, numbers) = simulation.settings, encoded(target)
        last = self._wanted[-1] if self._wanted else None
        if last is not None and last.settings is settings and last.code == code and last.numbers == numbers:
            last.steps += 1
        else:
            self._wanted.append(_Wanted(settings, code, numbers))
        self._expected = simulation.steps + 1

    def take_back(self) -> None:
        """Remove the newest record, whose step was not made."""
        self._wanted[-1].steps -= 1
        if not self._wanted[-1].steps:
            self._wanted.pop()
        self._expected -= 1

    def note_answers(self, simulation: Simulation) -> None:
        """Record the custom law's answer, after the step."""
        if self._law is not None:
            self._answers.append(np.hstack(simulation.answers).tobytes())

    def _leads_to(self, simulation: Simulation) -> bool:
        """True if the log ends at the present step."""
        same_run = simulation.roles is self._roles and law_of_file(simulation) is self._law
        return same_run and simulation.steps == self._expected

    def _begin_chapter(self, simulation: Simulation) -> None:
        if self._wanted:
            self._chapters.append(self._open_chapter())
        self._snapshot, self._wanted, self._answers = simulation.snapshot(), [], []
        self._turn = simulation.steps + max(round(CHAPTER / simulation.settings.dt), 1)
        while len(self._chapters) > 1:
            if simulation.time - self._chapters[1].begin < self._keep and self.nbytes <= self._most_bytes:
                return
            self._chapters.popleft()

    def _open_chapter(self) -> Recorded:
        assert self._snapshot is not None
        stretches: list[Stretch] = []
        answers = iter(self._answers)
        for settings, group in groupby(self._wanted, attrgetter("settings")):
            wanted = list(group)
            codes, counts = (
                np.array([one.code for one in wanted], np.uint8),
                np.array([one.steps for one in wanted], np.uint32),
            )
            targets = PackedTargets(codes, counts, np.frombuffer(b"".join(one.numbers for one in wanted)))
            answered = None
            if self._law is not None:
                rows = list(islice(answers, targets.steps))
                answered = LawAnswers(
                    self._law.file, self._law.sha256, np.frombuffer(b"".join(rows)).reshape(len(rows), -1)
                )
            stretches.append(Stretch(settings, targets, answered))
        return Recorded(self._snapshot, tuple(stretches))

    def cut(self, simulation: Simulation) -> tuple[Snapshot, tuple[Recorded, ...]]:
        """Present state, and the pieces that lead to it, if any; later steps start a new piece."""
        if not self._leads_to(simulation):
            return simulation.snapshot(), ()
        if self._wanted:
            self._begin_chapter(simulation)
        return simulation.snapshot(), tuple(self._chapters)

    def restore(self, pieces: Sequence[Recorded], simulation: Simulation) -> None:
        """Restore the pieces of `cut`, if they and the simulation both have a custom law, or neither has."""
        self.forget()
        law = law_of_file(simulation)
        if not pieces or (pieces[-1].law is None) != (law is None):
            return
        self._chapters.extend(pieces)
        self._expected = self._turn = simulation.steps
        self._roles, self._law = simulation.roles, law

    def window(self, seconds: float = KEEP) -> Recorded | None:
        """Newest `seconds` of the run, up to `CHAPTER` longer, or all of it; None if empty."""
        chapters, newest, length = list(self._chapters), list[Recorded](), 0.0
        if self._wanted:
            chapters.append(self._open_chapter())
        for chapter in reversed(chapters):
            if length >= seconds * (1.0 - 1e-9):
                break
            newest.insert(0, chapter)
            length += chapter.seconds
        if not newest:
            return None
        return Recorded(
            newest[0].snapshot,
            merged_stretches([stretch for chapter in newest for stretch in chapter.stretches]),
        )


def law_of_file(simulation: Simulation) -> LawOfFile | None:
    """Custom law, or None."""
    law = simulation.given_law
    return law if law is not None and isinstance(law, LawOfFile) else None


def merged_stretches(stretches: list[Stretch]) -> tuple[Stretch, ...]:
    merged: list[Stretch] = []
    for settings, group in groupby(stretches, attrgetter("settings")):
        parts = list(group)
        answers = [part.answers for part in parts if part.answers is not None]
        joined = (
            answers[-1]._replace(rows=np.concatenate([part.rows for part in answers])) if answers else None
        )
        merged.append(Stretch(settings, joined_targets([part.targets for part in parts]), joined))
    return tuple(merged)
