"""Entrants of the league; the runs of files are fenced."""

import hashlib
import os
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import msgspec

from app.features.custom_law.custom_law import CustomLaw, read_law
from app.features.league.league_runs import Event, Outcome, Schedule, held, law_held
from app.features.marks.fence import FenceLimits, fenced, fenced_input, say
from controllers.compiled import load_if_compiled
from controllers.errors import BadInputFile, DuetError
from controllers.kinematics import Array
from controllers.laws.situation import Situation
from scenes.files import readable
from scenes.laws import LAWS
from scenes.settings import RunSettings

OFFSETS: Final = (-0.12, 0.30)
"""Reduction of the distances that a file's law sees: its knob's range [m]."""


class Entrant(msgspec.Struct, frozen=True):
    """`text`: of the file; None for a built-in law."""

    name: str
    text: bytes | None = None

    @property
    def label(self) -> str:
        return LAWS[self.name].label if self.text is None else self.name

    @property
    def sha256(self) -> str:
        """Hash of the file; "" for a built-in law."""
        return "" if self.text is None else hashlib.sha256(self.text).hexdigest()

    @property
    def knob(self) -> str:
        """Setting that decides its distance, "offset" for a file, or ""."""
        if self.text is not None:
            return "offset"
        knob = LAWS[self.name].distance_knob
        return "" if knob is None else knob.key


def entrants(paths: list[Path]) -> list[Entrant]:
    """All built-in laws, and each file's law once.

    Raises:
        BadInputFile: a file cannot be read, or has no unique name.
    """
    found = [Entrant(name) for name, law in LAWS.items() if law.in_league]
    taken, files = set(LAWS), set[str]()
    for path in paths:
        file = os.path.realpath(path)
        if file in files:
            continue
        files.add(file)
        names = map(readable, (path.name, str(path), str(path.absolute())))
        name = next((name for name in names if name not in taken), None)
        if name is None:
            raise BadInputFile(f"{readable(str(path))}: has the name of another law; give it another one.")
        taken.add(name)
        found.append(Entrant(name, read_law(path)))
    return found


def played(entrant: Entrant, schedule: Schedule, event: Event, limits: FenceLimits) -> Outcome:
    """Errors of a file become its outcome's problem."""
    if entrant.text is None:
        return law_held(entrant.name, schedule, event)
    outcomes: list[Outcome] = []

    def take(said: dict[str, Any]) -> None:
        if "outcome" in said:
            outcomes.append(msgspec.convert(said["outcome"], Outcome))

    # Not as an argument, which the file could read: the hidden half follows from it.
    asked = msgspec.json.encode((schedule, event)) + b"\n" + entrant.text
    why = fenced("app.features.league.entrants", [entrant.name], asked, take, limits)
    return outcomes[0] if outcomes else Outcome(None, None, (), None, f"{why}", limits.seconds)


class _Failed(DuetError): ...


class _ShiftedLaw(CustomLaw):
    """Law that sees distances reduced by `offset` [m]."""

    offset = 0.0

    def __call__(self, situation: Situation) -> Array:
        distances = None if situation.distances is None else situation.distances - self.offset
        shifted = situation._replace(distance=situation.distance - self.offset, distances=distances)
        velocities = super().__call__(shifted)
        if self.problem is not None:
            raise _Failed(str(self.problem.text))
        return velocities

    def activation(self, distance: float) -> float:
        return super().activation(distance - self.offset)


def main() -> None:
    limits, (name,), given = fenced_input()
    load_if_compiled()
    asked, _, text = given.partition(b"\n")
    schedule, event = msgspec.json.decode(asked, type=tuple[Schedule, Event])
    law = _ShiftedLaw(Path(name), limits, waits=True, text=text)
    with law:

        def applied(settings: RunSettings, value: float | None) -> tuple[RunSettings, CustomLaw]:
            law.offset = value or 0.0
            return settings, law

        try:
            if not law.load():
                raise _Failed(str(law.problem.text) if law.problem else f"{name}: cannot be loaded.")
            outcome = held(schedule, event, applied, OFFSETS)
        except (_Failed, BadInputFile) as error:
            outcome = Outcome(None, None, (), None, str(error))
    say({"outcome": asdict(outcome)})
