"""Files of the league."""

import hashlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import msgspec

from app.features.league.entrants import Entrant
from app.features.league.league_runs import (
    CRITICAL_DISTANCE,
    EDITION,
    NATURAL_SPEED,
    NOMINAL_VELOCITY,
    Event,
    LeagueRun,
    Outcome,
    Schedule,
    events,
)
from app.features.sweep.dask_cluster import environment
from controllers.errors import BadInputFile, BadSetting
from scenes.files import csv_text, input_content, writable, written
from scenes.settings import values

PART: Final = "league.part.jsonl"
"""Outcomes so far, one per line."""


class Played(msgspec.Struct, frozen=True):
    """Outcome of an entrant. `sha256`: of the file, "" for a built-in law."""

    name: str
    sha256: str
    event: Event
    outcome: Outcome

    @property
    def key(self) -> tuple[str, str, Event]:
        return self.name, self.sha256, self.event


class LeagueFiles:
    """Outcomes of the league in a folder.

    Args:
        entrants: outcomes of others are kept.

    Raises:
        BadSetting: it holds another league.
        BadInputFile: it cannot be read.
    """

    def __init__(self, folder: Path, schedule: Schedule, entrants: Sequence[Entrant]) -> None:
        self.folder, self.schedule, self.entrants = folder, schedule, entrants
        self._part = folder / PART
        # The files must not reveal the word.
        word = hashlib.sha256(schedule.word.encode()).hexdigest()[:16] if schedule.word else ""
        plain = msgspec.to_builtins(schedule) | {"word": word}
        self._head = {"edition": EDITION, "schedule": plain, "versions": environment()}
        self._known = {one.key: one for one in self._read()} if self._part.exists() else {}

    @property
    def outcomes(self) -> list[Played]:
        """In the order of entrants and events."""
        keys = [(entrant.name, entrant.sha256, event) for entrant in self.entrants for event in events()]
        return [self._known[key] for key in keys if key in self._known]

    def missing(self, seconds: float) -> list[tuple[Entrant, Event]]:
        """Events not yet played, or given up with less time. `seconds`: allowed for a file [s]."""
        done = {key for key, one in self._known.items() if not 0.0 < one.outcome.given_up < seconds}
        return [
            (one, event)
            for one in self.entrants
            for event in events()
            if (one.name, one.sha256, event) not in done
        ]

    @contextmanager
    def recording(self) -> Iterator[Callable[[Entrant, Event, Outcome], None]]:
        """Function that writes an outcome at once.

        Raises:
            BadSetting: the folder cannot be written to.
        """
        with writable(self.folder, "out"):
            self.folder.mkdir(parents=True, exist_ok=True)
        # Written again: after a power failure the last line may be incomplete.
        with written(self._part, "out") as new:
            new.write_bytes(b"".join(_line(one) for one in (self._head, *self._known.values())))
        with writable(self._part, "out"), self._part.open("ab") as out:

            def add(entrant: Entrant, event: Event, outcome: Outcome) -> None:
                one = Played(entrant.name, entrant.sha256, event, outcome)
                with writable(self._part, "out"):
                    out.write(_line(one))
                    out.flush()
                self._known[one.key] = one

            yield add

    def finish(self) -> list[Path]:
        """Write `league.csv`, `league.json` and, with wall times, `times.csv`; returns the paths."""
        names = ("league.csv", "league.json", "times.csv")
        times = [
            (one.name, *one.event, "" if one.outcome.step_us is None else one.outcome.step_us)
            for one in self.outcomes
        ]
        times_table = csv_text([("law", "scene", "robot", "level", "step_us"), *times]).encode()
        texts = (_runs_table(self.outcomes), self._settings_and_outcomes(), times_table)
        for name, text in zip(names, texts, strict=True):
            with written(self.folder / name, "out") as new:
                new.write_bytes(text)
        return [self.folder / name for name in names]

    def _settings_and_outcomes(self) -> bytes:
        own = {
            f"{event.scene}, {event.robot}": values(event.settings(self.schedule.persons()[0]))
            for event in events()
            if event.level == "default"
        }
        numbers = {"d_m": CRITICAL_DISTANCE, "v": NOMINAL_VELOCITY, "natural_speed": NATURAL_SPEED}
        outcomes = [
            {"law": one.name, "sha256": one.sha256, **one.event._asdict(), **msgspec.to_builtins(one.outcome)}
            for one in self.outcomes
        ]
        for one in outcomes:
            del one["step_us"], one["given_up"]
        found = {
            **self._head,
            **numbers,
            "hidden_half": bool(self.schedule.word),
            "settings": own,
            "outcomes": outcomes,
        }
        return msgspec.json.format(msgspec.json.encode(found), indent=1) + b"\n"

    def _read(self) -> list[Played]:
        try:
            lines = input_content(self._part, 100_000_000).split(b"\n")
            head: dict[str, Any] = msgspec.json.decode(lines[0])
            # After the last line break a write was interrupted.
            found = [msgspec.json.decode(line, type=Played) for line in lines[1:-1]]
        except msgspec.MsgspecError:
            raise BadInputFile(
                f"{self._part}: is not what a league has written; remove it, or give another --out."
            ) from None
        mine = msgspec.json.decode(msgspec.json.encode(self._head))
        for key in mine:
            if head.get(key) != mine[key]:
                raise BadSetting(
                    f"out = {self.folder}: holds a league of other {_CALLED[key]}; give another --out, or remove {PART}."
                )
        return found


_CALLED: Final = {
    "edition": "runs (another edition)",
    "schedule": "persons (--quick or --seed-word)",
    "versions": "versions",
}
"""Part of the head → name in messages."""


def _line(one: object) -> bytes:
    return msgspec.json.encode(one) + b"\n"


def _runs_table(outcomes: Sequence[Played]) -> bytes:
    columns = ("law", "level", "scene", "robot", "knob_value", "half", "person", "speed_m_s")
    figures = ("lost_m", "d_min_m", "e2_max", "dq_step_rad_s", "at_bounds_s", "problem")
    rows: list[Sequence[object]] = []
    for one in outcomes:
        event, outcome = one.event, one.outcome
        about = (
            one.name,
            event.level,
            event.scene,
            event.robot,
            "" if outcome.value is None else outcome.value,
        )
        rows += [(*about, *run, "") for run in outcome.runs]
        if outcome.problem:
            rows.append((*about, *("",) * len(LeagueRun._fields), outcome.problem))
    return csv_text([(*columns, *figures), *rows]).encode()
