"""Recorded inputs as a file: an .npz archive, checked completely when read."""

import io
import json
import math
import re
import zipfile
from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import numpy as np

from controllers.errors import BadInputFile, BadSetting, LazyText
from controllers.kinematics import Array
from scenes.files import input_content
from scenes.inputs import Recorded, RecordedPerson, Stretch
from scenes.law_answers import LawAnswers
from scenes.packing import ANGLES, JOINTS, KINDS, LINK, ROTATION, TURNED, WALL, WIDTHS, PackedTargets
from scenes.recording import REACH, inputs_from
from scenes.roles import TargetSource, room_of
from scenes.settings import RunSettings, changed, values
from scenes.simulation import Simulation, Snapshot
from scenes.targets import AnglesTarget

VERSION: Final = 2
"""For answers of a custom law; other files have version 1, for older programs."""
FORMAT: Final = "duet inputs"

LARGEST_FILE: Final = 64_000_000
"""[B]"""

LARGEST_CONTENT: Final = 256_000_000
"""Unpacked [B]."""

MOST_STEPS: Final = 1_000_000

FASTEST: Final = 50.0
"""Largest plausible joint velocity [rad/s]."""

WIDEST: Final = 4.0 * math.pi
"""Largest plausible angle [rad]."""

_ARRAYS: Final = ("about", "lengths", "codes", "counts", "numbers", "positions", "velocities")


def recorded_bytes(recorded: Recorded, further: Mapping[str, np.ndarray] = {}) -> bytes:
    """Content of a file; equal inputs give equal bytes. `further`: more parts, by name."""
    settings = [values(stretch.settings) for stretch in recorded.stretches]
    changes = [{key: b[key] for key in b if a[key] != b[key]} for a, b in pairwise(settings)]
    snapshot = recorded.snapshot
    about = {
        "format": FORMAT,
        "version": 1,
        "settings": settings[0],
        "changes": changes,
        "steps": snapshot.steps,
        "time": snapshot.time,
        "memories": [len(memory) for memory in snapshot.memories],
    }
    if recorded.law is not None:
        about |= {"version": VERSION, "law_file": recorded.law.file, "law_sha256": recorded.law.sha256}
    targets = [stretch.targets for stretch in recorded.stretches]
    arrays: dict[str, np.ndarray] = {
        "about": np.frombuffer(json.dumps(about).encode(), np.uint8),
        "lengths": np.array([len(part.codes) for part in targets], np.uint32),
        "codes": np.concatenate([part.codes for part in targets]),
        "counts": np.concatenate([part.counts for part in targets]),
        "numbers": np.concatenate([part.numbers for part in targets]),
        "positions": snapshot.positions,
        "velocities": snapshot.velocities,
    }
    arrays |= {f"robot_{i}": array for i, array in enumerate(snapshot.robot)}
    answers = [stretch.answers.rows.ravel() for stretch in recorded.stretches if stretch.answers is not None]
    if answers:
        arrays["answers"] = np.concatenate(answers)
    for i, memory in enumerate(snapshot.memories):
        arrays |= {f"memory_{i}_{j}": array for j, array in enumerate(memory)}
    out = io.BytesIO()
    np.savez_compressed(out, **arrays, **further)  # pyright: ignore[reportArgumentType]
    return out.getvalue()


def read_recorded(path: Path) -> Recorded:
    """Recorded inputs of a file.

    Raises:
        BadInputFile: missing, of another kind, damaged or impossible.
    """
    return recorded_from(_content(path), str(path))


def read_person(path: Path, settings: RunSettings) -> TargetSource:
    """Source of recorded inputs, or of a CSV with the header t,x,y,z….

    Raises:
        BadInputFile: neither, or recorded in another scene or with other arms.
    """
    data = _content(path)
    if not data.startswith(b"PK"):
        return inputs_from(data, str(path))
    recorded = recorded_from(data, str(path))
    if recorded.settings.scene != settings.scene:
        scene = recorded.settings.scene
        raise BadInputFile(
            "{name}: was recorded in the scene {scene}, not {here}; add --scene {scene}.",
            name=path,
            scene=scene,
            here=settings.scene,
        )
    kinds = {
        kind
        for stretch in recorded.stretches
        for code in set(stretch.targets.codes.tolist())
        for kind in KINDS[code]
    }
    if any(kind == LINK or kind > JOINTS for kind in kinds) and _joint_counts(
        recorded.settings
    ) != _joint_counts(settings):
        raise BadInputFile(
            "{name}: pulls at joints of other arms than these; add --robot {robot} --guided {guided}.",
            name=path,
            robot=recorded.settings.robot,
            guided=recorded.settings.guided,
        )
    return RecordedPerson(recorded)


def _joint_counts(settings: RunSettings) -> list[int]:
    arms = room_of(settings).arms
    return [
        arm.joints.stop - arm.joints.start
        for arm in sorted(arms, key=lambda arm: arm.name != settings.guided)
    ]


def _content(path: Path) -> bytes:
    return input_content(path, LARGEST_FILE, larger=_too_large(str(path)))


def recorded_from(data: bytes, name: str) -> Recorded:
    """See `parts_from`."""
    return parts_from(data, name)[0]


def parts_from(data: bytes, name: str) -> tuple[Recorded, dict[str, np.ndarray]]:
    """Recorded inputs of a file's content, and all its parts by name; `further` parts are not checked.

    Raises:
        BadInputFile: see `read_recorded`.
    """
    if len(data) > LARGEST_FILE:
        raise _too_large(name)
    try:
        arrays = _unpacked(data)
        return _recorded(arrays), arrays
    except BadSetting as error:
        raise BadInputFile("{name}: {reason}", name=name, reason=str(error)) from None
    except _Damage as damage:
        raise BadInputFile("{name}: {reason}.", name=name, reason=damage.args[0]) from None
    except KeyError as missing:
        raise BadInputFile(
            "{name}: is not a file of recorded inputs, or its part {part} is missing.",
            name=name,
            part=f"{missing.args[0]!s:.80}",
        ) from missing
    except Exception as error:
        # zipfile and numpy raise almost any kind of error for a damaged archive.
        raise BadInputFile("{name}: is not a file of recorded inputs, or is damaged.", name=name) from error


class _Damage(Exception):
    """The message names the damage."""


def _check(fine: object, what: str, /, **parts: object) -> None:
    if not fine:
        raise _Damage(LazyText(what, **parts))


def _too_large(name: str) -> BadInputFile:
    return BadInputFile(
        "{name}: is larger than {size} MB; recorded inputs are not.",
        name=name,
        size=LARGEST_FILE // 1_000_000,
    )


def _unpacked(data: bytes) -> dict[str, np.ndarray]:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        # Before unpacking: a small archive may have a huge content.
        _check(
            sum(info.file_size for info in archive.infolist()) <= LARGEST_CONTENT,
            "unpacks to more than recorded inputs can be",
        )
        _check(len(archive.infolist()) <= 200, "holds too many parts")
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        found = {name: arrays[name] for name in arrays.files}
    _check(set(_ARRAYS) <= set(found), "is not a file of recorded inputs: a part is missing")
    return found


def _recorded(arrays: dict[str, np.ndarray]) -> Recorded:
    about: dict[str, Any] = json.loads(arrays["about"].tobytes().decode())
    _check(isinstance(about, dict) and about.get("format") == FORMAT, "is not a file of recorded inputs")
    version = about["version"]
    _check(
        isinstance(version, int) and 1 <= version <= VERSION,
        "is of version {version}, and this program reads up to {newest}; use a newer one",
        version=f"{version!s:.80}",
        newest=VERSION,
    )
    lengths = arrays["lengths"]
    _check(lengths.ndim == 1 and lengths.dtype.kind == "u", "has no lengths")
    _check(1 <= len(lengths) <= 50_000 and (lengths > 0).all(), "has an impossible number of stretches")
    settings = _settings(about, len(lengths))
    targets = _targets(arrays, int(lengths.astype(np.uint64).sum()), _joint_counts(settings[0]))
    snapshot = _snapshot(about, arrays, settings[0])
    stretches: list[Stretch] = []
    first = 0
    begins = np.append(targets.offsets, len(targets.numbers))
    for s, length in zip(settings, lengths.tolist(), strict=True):
        last = first + length
        numbers = targets.numbers[begins[first] : begins[last]]
        numbers.flags.writeable = False
        stretches.append(
            Stretch(s, PackedTargets(targets.codes[first:last], targets.counts[first:last], numbers))
        )
        first = last
    recorded = Recorded(snapshot, tuple(stretches))
    return recorded if version == 1 else _with_answers(recorded, about, arrays)


def _with_answers(recorded: Recorded, about: dict[str, Any], arrays: dict[str, np.ndarray]) -> Recorded:
    file, sha256, numbers = about["law_file"], about["law_sha256"], arrays["answers"]
    named = (
        isinstance(file, str)
        and len(file) <= 255
        and len(file.splitlines()) == 1
        and re.fullmatch("[0-9a-f]{64}", str(sha256))
    )
    _check(named, "does not name the file of its law")
    simulation, shapes = Simulation(recorded.settings, 1), list[tuple[int, int]]()
    for settings, targets, _ in recorded.stretches:
        simulation.apply(settings)
        shapes.append((targets.steps, 1 + simulation.avoiding_joints))
    ends = np.cumsum([steps * width for steps, width in shapes])
    _check(
        numbers.shape == (ends[-1],),
        "has {found} numbers as answers of its law, but its steps need {needed}",
        found=numbers.size,
        needed=int(ends[-1]),
    )
    _check(numbers.dtype == np.float64 and np.isfinite(numbers).all(), "has impossible answers of its law")
    stretches: list[Stretch] = []
    for stretch, shape, part in zip(recorded.stretches, shapes, np.split(numbers, ends[:-1]), strict=True):
        rows = part.reshape(shape)
        _check(((rows[:, 0] >= 0.0) & (rows[:, 0] <= 1.0)).all(), "has impossible answers of its law")
        stretches.append(stretch._replace(answers=LawAnswers(file, sha256, rows)))
    return replace(recorded, stretches=tuple(stretches))


def _settings(about: dict[str, Any], stretches: int) -> list[RunSettings]:
    given, changes = about["settings"], about["changes"]
    _check(isinstance(given, dict) and isinstance(changes, list), "has no settings")
    _check(len(changes) == stretches - 1, "has settings that do not fit its stretches")
    settings = RunSettings()
    for key, value in given.items():
        settings = changed(settings, key, value)
    found = [settings]
    for change in changes:
        for key, value in change.items():
            _check(
                key not in ("scene", "rig", "robot", "guided", "path", "point", "first", "load", "together"),
                "changes {key} in the middle of the run",
                key=key,
            )
            settings = changed(settings, key, value)
        found.append(settings)
    return found


def _targets(arrays: dict[str, np.ndarray], count: int, links: list[int]) -> PackedTargets:
    """The checked targets. `count`: of different targets; `links`: see `_joint_counts`."""
    codes, counts, numbers = arrays["codes"], arrays["counts"], arrays["numbers"]
    _check(
        (codes.dtype, counts.dtype, numbers.dtype) == (np.uint8, np.uint32, np.float64),
        "has targets of the wrong type",
    )
    _check(codes.shape == counts.shape == (count,) and numbers.ndim == 1, "has targets of the wrong number")
    _check(np.isin(codes, list(WIDTHS)).all(), "has targets of an unknown kind")
    _check(
        (counts > 0).all() and int(counts.astype(np.uint64).sum()) <= MOST_STEPS,
        "has an impossible number of steps",
    )
    targets = PackedTargets(codes, counts, numbers)
    offsets = targets.offsets
    _check(len(numbers) == int(offsets[-1]) + WIDTHS[int(codes[-1])], "has targets with missing numbers")
    _check(np.isfinite(numbers).all(), "has targets that are not finite")

    for code in np.unique(codes).tolist():
        rows = numbers[offsets[codes == code][:, None] + np.arange(WIDTHS[code])]
        begin = 0
        for kind, joints in zip(KINDS[code], (links[0], links[-1]), strict=False):
            _check_targets(kind, rows[:, begin : begin + WIDTHS[kind]], joints)
            begin += WIDTHS[kind]
    return targets


def _check_targets(kind: int, rows: Array, joints: int) -> None:
    """Check targets of a kind by their numbers (k, width).

    `rows`: targets of a kind (k, width); `joints`: of the arm.
    """
    if kind == ANGLES or kind > JOINTS:
        _check(kind == ANGLES or kind - JOINTS == joints, "moves joints that the arm does not have")
        _check((np.abs(rows) <= WIDEST).all(), "has an angle beyond two turns")
        return
    places = rows
    if kind == LINK:
        _check(np.isin(rows[:, 0], range(1, joints + 1)).all(), "pulls a link that no arm has")
        places = rows[:, 1:]
    elif kind == WALL:
        _check((np.abs(rows[:, 3:]) <= WIDEST).all(), "has an angle beyond two turns")
        places = rows[:, :3]
    elif kind & (ROTATION | TURNED):
        _check(_are_rotations(rows[:, 3:12]), "has an orientation that is not valid")
        places = np.delete(rows, np.s_[3:12], axis=1)
    _check((np.abs(places) <= REACH).all(), "has a target that is out of any reach")


def _are_rotations(rows: Array) -> bool:
    R = rows.reshape(-1, 3, 3)
    orthonormal = np.abs(np.einsum("kij,klj->kil", R, R) - np.eye(3)).max(initial=0.0) < 1e-6
    return bool(orthonormal and (np.einsum("ki,ki->k", np.cross(R[:, 0], R[:, 1]), R[:, 2]) > 0.0).all())


def _snapshot(about: dict[str, Any], arrays: dict[str, np.ndarray], settings: RunSettings) -> Snapshot:
    steps, time = about["steps"], about["time"]
    _check(
        type(steps) is int and steps >= 0 and type(time) is float and 0.0 <= time < 1e9,
        "begins at an impossible time",
    )
    # Only the experiment knows its shapes; some have a state only after a person was seen.
    simulation = Simulation(settings, 1)
    usual = simulation.snapshot().memories
    lengths = about["memories"]
    if lengths != [len(memory) for memory in usual]:
        simulation.step(AnglesTarget(np.zeros((2, 4))))
        usual = simulation.snapshot().memories
    positions, velocities = arrays["positions"], arrays["velocities"]
    _check(
        positions.shape == velocities.shape == simulation.positions.shape, "begins in a posture of other arms"
    )
    _check(lengths == [len(memory) for memory in usual], "begins in another experiment")
    memories: list[tuple[Array, ...]] = []
    for i, memory in enumerate(usual):
        stored = tuple(arrays[f"memory_{i}_{j}"] for j in range(len(memory)))
        same = all(a.shape == b.shape and a.dtype == b.dtype for a, b in zip(stored, memory, strict=True))
        _check(same, "begins in another experiment")
        memories.append(stored)
    # Files made before the lag had a state of its own have four parts.
    robot = (
        (*(arrays[f"robot_{i}"] for i in range(4)), arrays.get("robot_4", np.empty(0)))
        if "robot_0" in arrays
        else ()
    )
    _check(not robot or _is_robot(robot, len(positions)), "begins with an impossible robot")
    everything = [positions, velocities, *robot, *(array for memory in memories for array in memory)]
    _check(all(array.dtype.kind in "fiub" for array in everything), "begins with no numbers")
    _check(positions.dtype == velocities.dtype == np.float64, "begins with numbers of the wrong type")
    _check(
        (np.abs(positions) <= WIDEST).all() and (np.abs(velocities) <= FASTEST).all(),
        "begins in an impossible posture",
    )
    _check(all((np.abs(array) < 1e6).all() for array in everything), "begins with an impossible number")
    return Snapshot(settings, steps, time, positions, velocities, tuple(memories), robot)


def _is_robot(robot: tuple[Array, ...], nv: int) -> bool:
    """True for plausible states of `Actuation` and `Sensing`."""
    times, commands, held, frame, end = robot
    typed = times.dtype == commands.dtype == held.dtype == end.dtype == np.float64 and frame.dtype == np.int64
    shaped = times.ndim == 1 and commands.shape == (len(times), nv) and frame.shape == ()
    shaped = (
        shaped
        and held.shape in ((0,), (nv,))
        and end.shape in ((0,), (nv,))
        and bool((np.abs(end) <= FASTEST).all())
    )
    if not (typed and shaped):
        return False
    # Without a posture there was no frame.
    seen = int(frame) >= 0 if len(held) else int(frame) == -1
    return bool(
        seen
        and (np.diff(times) > 0.0).all()
        and (np.abs(commands) <= FASTEST).all()
        and (np.abs(held) <= WIDEST).all()
    )
