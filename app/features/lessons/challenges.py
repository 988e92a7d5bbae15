"""Reads challenges and measurements of a step's block."""

import re
from functools import partial
from typing import Final

from app.features.custom_law.trials import TRIALS
from app.features.lessons.blocks import Table, is_number, quoted_value
from app.features.lessons.lesson import (
    MOST_FORECASTS,
    Challenge,
    Compared,
    Criterion,
    Forecast,
    Measurement,
    Trial,
)
from app.features.lessons.markdown import FaultLog
from app.features.lessons.runs import Setup
from app.features.lessons.setups import read_changes, read_setup, start_of_table
from app.features.measures.quantities.quantity import QUANTITIES, read_parameters
from app.features.measures.room_places import start_positions
from scenes.laws import LAWS
from scenes.roles import room_of
from scenes.setting_spec import unknown_setting
from scenes.settings import specs
from scenes.solo import has_null_motions

MOST_COMPARED: Final = 4
MOST_PUSHES: Final = 9

IDENTITY: Final = re.compile(r"^[a-z][a-z0-9_]{0,39}$")


def read_identity(table: Table, default: str) -> str:
    found = table.text("id", default, 40)
    if not IDENTITY.match(found):
        raise table.fault(
            "id",
            f"id = {quoted_value(found)} is not possible; use small letters, digits and _, a letter first.",
        )
    return found


def no_doubles(table: Table, key: str, ids: list[str]) -> None:
    for id in ids:
        if ids.count(id) > 1:
            raise table.fault(key, f"{key}: two are called {id}; give one of them another id.")


def read_measurement(table: Table, setup: Setup) -> Measurement:
    name = table.choice("name", sorted(QUANTITIES))
    found = QUANTITIES[name]
    id = read_identity(table, name)
    unit = table.choice("unit", found.units, found.shown)
    digits = table.whole("digits", found.digits, 0, 6)
    compare = [_compared(entry, setup) for entry in table.tables("compare")]
    if len(compare) > MOST_COMPARED:
        raise table.fault(
            "compare", f"compare names {len(compare)} further runs; take at most {MOST_COMPARED}."
        )
    text_only = table.flag("text_only")
    given = {key: table.any(key) for key in found.parameters if table.has(key)}
    read = partial(read_parameters, f"measurement {name}")
    for key, value in given.items():
        table.checked(key, partial(read, {key: found.parameters[key]}, {key: value}))
    parameters = table.checked("name", partial(read, found.parameters, given))
    if name == "setting" and given["key"] not in specs():
        raise table.fault("key", str(unknown_setting(given["key"], specs())))
    table.close()
    return Measurement(id, name, parameters, unit, digits, tuple(compare), text_only)


def _compared(table: Table, setup: Setup) -> Compared:
    start = start_of_table(table) if table.has("start") else None
    compared = Compared(read_changes(table, ""), start)
    if not compared.changes and start is None:
        raise table.fault(
            "compare", "a comparison needs settings that differ, as in compare = [{ dt = 0.01 }]."
        )
    other = compared.setup(setup)
    table.checked("start" if start else "compare", lambda: start_positions(room_of(other.run), other.start))
    return compared


def read_challenge(table: Table, setup: Setup) -> Challenge | None:
    given = table.table("challenge")
    if given is None:
        return None
    run = read_setup(given, setup)
    log = FaultLog()
    criteria = log.all_of(partial(_criterion, entry, run) for entry in given.tables("criterion"))
    log.close()
    forecasts: list[Forecast] = []
    for entry in given.tables("forecast"):
        changes = read_changes(entry)
        within = entry.number("within", 0.05, 1e-6, 1.0)
        forecasts.append(Forecast(read_measurement(entry, run), changes, within))
    if len(forecasts) > MOST_FORECASTS:
        raise given.fault(
            "forecast", f"the challenge asks for {len(forecasts)} forecasts; take at most {MOST_FORECASTS}."
        )
    custom_law, keep, sliders = given.flag("own_law"), given.text("keep", "", 40), given.flag("null_motions")
    if sliders and (
        run.run.experiment.obstacle != "nothing"
        or run.run.draws_circle
        or not has_null_motions(room_of(run.run).arms[0])
    ):
        raise given.fault(
            "null_motions", "null_motions needs the scene solo, the path stay, and a robot of 7 joints."
        )
    search = (
        given.choice("search", [key for key, spec in specs().items() if spec.is_number], "")
        if given.has("search")
        else ""
    )
    if search and not criteria:
        raise given.fault(
            "search", "search plots tries against the first inequality; add [[challenge.criterion]]."
        )
    best_of = given.whole("best_of", 0, 0, MOST_PUSHES)
    if best_of and (
        run.input.kind != "yours" or not criteria or criteria[0].measurement.name != "distance_margin"
    ):
        raise given.fault(
            "best_of",
            "best_of needs input = “yours”, and distance_margin as the first [[challenge.criterion]].",
        )
    if not criteria and not forecasts and not custom_law:
        raise given.fault(
            "criterion",
            "the challenge asks for nothing; add [[challenge.criterion]] or [[challenge.forecast]].",
        )
    no_doubles(
        given, "criterion", [c.measurement.id for c in criteria] + [f.measurement.id for f in forecasts]
    )
    given.close()
    return Challenge("", run, criteria, tuple(forecasts), custom_law, keep, sliders, search, best_of)


def _criterion(table: Table, setup: Setup) -> Criterion:
    equals = table.any("equals")
    low = table.number("at_least") if table.has("at_least") else None
    high = table.number("at_most") if table.has("at_most") else None
    measurement = read_measurement(table, setup)
    if equals is not None:
        if measurement.name != "setting" or low is not None or high is not None:
            raise table.fault(
                "equals", "equals is for a setting alone: name = “setting”, key = …, equals = …"
            )
        key = str(dict(measurement.parameters)["key"])
        spec = specs()[key]
        if spec.choices and equals in spec.choices:
            low = high = float(spec.choices.index(str(equals)))
        elif isinstance(equals, (int, float)) and spec.is_number:
            low = high = float(equals)
        else:
            raise table.fault(
                "equals",
                f"equals = {quoted_value(equals)} is not possible; choose from {', '.join(spec.choices)}.",
            )
    if low is None and high is None:
        raise table.fault("name", "the inequality has no bound; add at_least = … or at_most = … in SI units.")
    if low is not None and high is not None and low > high:
        raise table.fault("at_least", f"at_least = {low:g} is above at_most = {high:g}; nothing can pass.")
    return Criterion(measurement, low, high)


def read_trials(
    table: Table, challenge: Challenge | None, measurements: tuple[Measurement, ...]
) -> tuple[Trial, ...]:
    entries = table.tables("attempt")
    if challenge is None:
        if entries:
            raise table.fault("attempt", "an attempt needs a challenge; add [challenge].")
        return ()
    known = [c.measurement.id for c in challenge.criteria] + [f.measurement.id for f in challenge.forecasts]
    if challenge.custom_law:
        known += TRIALS
    log = FaultLog()

    def trial(number: int, entry: Table) -> Trial:
        name = entry.text("name", f"attempt {number}", 60)
        run = read_setup(entry, challenge.setup)
        given = entry.any("forecasts", [])
        if not isinstance(given, list):
            raise entry.fault(
                "forecasts", f"forecasts = {quoted_value(given)} is not a list, like forecasts = [0.5]."
            )
        said = tuple(_said(entry, x, measurements) for x in given)
        law = entry.choice("law", LAWS, "") if entry.has("law") else ""
        fails = entry.words("fails", known, len(known))
        if len(said) != len(challenge.forecasts):
            raise entry.fault(
                "forecasts",
                f"forecasts has {len(said)} numbers; the challenge asks for {len(challenge.forecasts)}.",
            )
        if bool(law) != challenge.custom_law:
            raise entry.fault(
                "law", "law stands in for the student's own; it belongs to a challenge with own_law."
            )
        entry.close()
        return Trial(name, run, said, law, fails)

    trials = log.all_of(partial(trial, number, entry) for number, entry in enumerate(entries, 1))
    log.close()
    return trials


def _said(table: Table, value: object, measurements: tuple[Measurement, ...]) -> float | str:
    if isinstance(value, str) and value in [m.id for m in measurements]:
        return value
    if is_number(value):
        return float(value)
    ids = ", ".join(m.id for m in measurements) or "none"
    raise table.fault(
        "forecasts",
        f"forecasts: {quoted_value(value)} is neither a number nor a measurement of the step ({ids}).",
    )
