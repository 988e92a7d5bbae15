"""The part of a block that describes a run; readers raise `Fault`."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Final, cast, get_args

from app.features.lessons.blocks import NEEDED, Table, is_number, quoted_value
from app.features.lessons.markdown import Fault, FaultLog
from app.features.lessons.runs import AUTOPILOT, LONGEST, Input, Pairs, Setup
from app.features.lessons.scripts import SCRIPTS, checked_script
from app.features.measures.room_places import Anchor, RoomPlace, Start, ball_centre, start_positions
from app.settings import Settings
from controllers.errors import BadInputFile, BadSetting
from scenes.files import path_inside
from scenes.recording import read_inputs
from scenes.roles import room_of
from scenes.sample_check import check_samples
from scenes.settings import changed

SHORTEST: Final = 0.1
"""Shortest run [s]."""

USUAL: Final = 8.0
"""Default length of a run [s]."""

_FORMERLY: Final = "nobody"
"""Former word for "none"."""

PLAIN: Final = ("autopilot", "none", "yours")


def read_changes(table: Table, key: str = "settings") -> Pairs:
    """With an empty key, the settings left in the table itself."""
    given = table.table(key) if key else table
    if given is None:
        return ()
    found, settings, log = [], Settings(), FaultLog()
    for name, value in given.rest().items():
        if not isinstance(value, (str, bool)) and not is_number(value):
            log.found.append(
                given.fault(name, f"{name} = {quoted_value(value)} is not a value of a setting.")
            )
            continue
        settings = log.take(partial(given.checked, name, partial(changed, settings, name, value)), settings)
        found.append((name, value))
    log.close()
    return tuple(found)


def usual_setup(folder: Path) -> Setup:
    return Setup((), AUTOPILOT, None, USUAL, folder)


def read_setup(table: Table, base: Setup) -> Setup:
    line = "settings" if table.has("settings") else "seconds"
    setup = base.with_changes(read_changes(table))
    setup = replace(setup, seconds=table.number("seconds", base.seconds, SHORTEST, LONGEST))
    table.checked(line, lambda: room_of(setup.run))
    start = start_of_table(table) if table.has("start") else base.start
    given = read_input(table, setup) if table.has("input") else base.input
    setup = replace(setup, input=given, start=start)
    table.checked("start" if start else line, lambda: start_positions(room_of(setup.run), start))
    if given.kind == "script":
        table.checked("input", lambda: checked_script(given.name, dict(given.parameters), setup.run.scene))
    return setup


def start_of_table(table: Table) -> Start | None:
    given = table.table("start")
    if given is None:
        return None
    ball = given.table("ball")
    place = _place(ball) if ball is not None else None
    posture = given.numbers("posture") if given.has("posture") else None
    given.close()
    return Start(place, posture)


def _place(table: Table) -> RoomPlace:
    origin = cast(Anchor, table.choice("from", get_args(Anchor), "goal"))
    gap, tilt = table.number("gap", NEEDED, -0.5, 3.0), table.number("tilt", 0.0, -3.2, 3.2)
    toward: Any = table.any("toward")
    if isinstance(toward, list) and len(toward) == 3 and all(is_number(x) and abs(x) < 1e6 for x in toward):
        toward = tuple(float(x) for x in toward)
    elif toward != "upper_arm":
        raise table.fault(
            "toward",
            f'toward = {quoted_value(toward)} is not a direction; write [0.0, 1.0, 0.0], or "upper_arm".',
        )
    table.close()
    return RoomPlace(origin, cast(Any, toward), gap, tilt)


def read_input(table: Table, setup: Setup) -> Input:
    value = table.any("input")
    if value == _FORMERLY:
        value = "none"
    if value in PLAIN:
        return Input(cast(Any, value))
    if isinstance(value, dict):
        return _read_input(table, dict(value), setup)
    remedy = 'write "yours" or { script = "push", speed = 0.2 }.'
    if isinstance(value, str):
        remedy = f"choose from {', '.join(PLAIN)}, or {{ script = … }}."
    raise table.fault("input", f"input = {quoted_value(value)} is not possible; {remedy}")


def _read_input(table: Table, value: dict[str, Any], setup: Setup) -> Input:
    kinds = [kind for kind in ("script", "file", "kept") if kind in value]
    if len(kinds) != 1 or not isinstance(value[kinds[0]], str):
        raise table.fault("input", f"input = {quoted_value(value)} must name one of script, file and kept.")
    kind, name = kinds[0], str(value.pop(kinds[0]))
    if kind == "script":
        return Input("script", name, table.checked("input", lambda: _script(name, value, setup)))
    if kind == "kept":
        otherwise = value.pop("otherwise", None)
        if not isinstance(otherwise, dict) or value or "kept" in otherwise:
            raise table.fault(
                "input", "kept needs otherwise = { script = … }: who moves as long as nothing was kept."
            )
        return Input("kept", name, (), _read_input(table, dict(otherwise), setup))
    if value:
        raise table.fault("input", f"a file has no parameters; leave out {', '.join(value)}.")
    table.checked("input", lambda: _file(name, setup))
    return Input("file", name)


def _script(name: str, given: dict[str, Any], setup: Setup) -> Pairs:
    found: dict[str, Any] = {}
    places = SCRIPTS[name].places if name in SCRIPTS else ()
    for key, value in given.items():
        found[key] = value
        if isinstance(value, dict) and key in places:
            try:
                found[key] = _place(Table(value, [], 1, key))
            except Fault as fault:
                raise BadSetting(f"script {name[:40]}: {fault.message}") from None
    checked = checked_script(name, found, setup.run.scene)
    if name == "wall_to" and room_of(setup.run).wall is None:
        raise BadSetting("The script wall_to needs a wall; set first = wall or first = all.")
    for _, value in checked:
        if isinstance(value, RoomPlace):
            ball_centre(room_of(setup.run), value)
    return checked


def _file(name: str, setup: Setup) -> None:
    path = path_inside(setup.folder, name)
    if path is None:
        raise BadSetting(
            f"file = {name[:60]!r} is outside the folder of the lesson; put it beside the lesson."
        )
    try:
        check_samples(read_inputs(path), setup.run, setup.seconds, str(path))
    except BadInputFile as error:
        raise BadSetting(str(error)) from None
