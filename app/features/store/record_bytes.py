"""A visitor's record as bytes: a head and parts."""

import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, replace
from typing import Any, Final, TypeVar

import msgspec
import numpy as np

from app.features.store.sqlite_pages import is_whole
from app.hosting.visitor_record import VisitorRecord, link_of
from app.session.session_state import RunState, SessionState
from controllers.errors import BadSetting
from scenes.inputs import Recorded
from scenes.roles import room_of

P = TypeVar("P")

_FIELDS: Final = frozenset(one.name for one in fields(VisitorRecord))

_NIL: Final = msgspec.msgpack.encode(None)


_TAB: Final = "\t"


class DamagedRecord(ValueError): ...


def record_to_bytes(data: object) -> bytes:
    """Compressed bytes with a check sum."""
    content = zlib.compress(msgspec.msgpack.encode(data, enc_hook=_array_out), 1)
    return zlib.crc32(content).to_bytes(4, "big") + content


def record_from_bytes(data: bytes, kind: type[P]) -> P:
    """Inverse of `record_to_bytes`.

    Raises:
        DamagedRecord: other bytes.
    """
    with _damage():
        return msgspec.msgpack.decode(_content(data), type=kind, dec_hook=_array_in)


def visitor_from_bytes(data: bytes) -> VisitorRecord:
    """`record_from_bytes` that also reads earlier releases, which stored features' parts as fields."""
    record = record_from_bytes(data, VisitorRecord)
    with _damage():
        stored = msgspec.msgpack.decode(_content(data), type=dict[str, msgspec.Raw])
    parts = {name: bytes(raw) for name, raw in stored.items() if name not in _FIELDS and bytes(raw) != _NIL}
    return replace(record, parts={**parts, **record.parts}) if parts else record


def _content(data: bytes) -> bytes:
    if not is_whole(data):
        raise DamagedRecord("the check sum is wrong")
    return zlib.decompress(data[4:])


@contextmanager
def _damage() -> Iterator[None]:
    try:
        yield
    except (msgspec.MsgspecError, zlib.error, ValueError, TypeError) as error:
        raise DamagedRecord(str(error)[:120]) from None


def _array_out(value: object) -> object:
    if isinstance(value, np.ndarray):
        # The order in memory counts: a product with a transposed matrix may have other last bits.
        return value.dtype.str, value.shape, value.flags.fnc, value.tobytes("A")
    raise TypeError(f"{type(value).__name__} cannot be stored")


def _array_in(kind: type[Any], value: Any) -> Any:
    dtype, shape, columns_first, content = value
    if np.dtype(dtype).kind not in "fiub":
        raise DamagedRecord(f"an array of {dtype}")
    return np.frombuffer(content, dtype).reshape(shape, order="F" if columns_first else "C").copy("K")


def split_record(record: VisitorRecord) -> tuple[VisitorRecord, dict[str, Recorded]]:
    """Record without its recorded pieces, and these by name."""
    parts, state = dict(record.recordings), record.state
    if state is not None:
        parts |= _numbered("run", state.run)
        if state.ghost is not None:
            parts |= _numbered("ghost", state.ghost)
        state = _with_pieces(state, (), ())
    query = {"resume": record.query.get("resume", ""), **link_of(record.query)}
    return replace(record, query=query, state=state, recordings={}), parts


def _numbered(kind: str, run: RunState) -> dict[str, Recorded]:
    return {f"{kind}{_TAB}{piece.snapshot.steps:012d}": piece for piece in run.pieces}


def _with_pieces(state: SessionState, run: tuple[Recorded, ...], ghost: tuple[Recorded, ...]) -> SessionState:
    beside = None if state.ghost is None else replace(state.ghost, pieces=ghost)
    return replace(state, run=replace(state.run, pieces=run), ghost=beside)


def joined_record(record: VisitorRecord, parts: Mapping[str, Recorded]) -> VisitorRecord:
    """Inverse of `split_record`; drops a session that is not possible here."""
    pieces: dict[str, list[Recorded]] = {"run": [], "ghost": []}
    recordings: dict[str, Recorded] = {}
    for name, piece in sorted(parts.items()):
        match name.split(_TAB):
            case [("run" | "ghost") as kind, _]:
                pieces[kind].append(piece)
            case _:
                recordings[name] = piece
    state = record.state
    if state is not None:
        ghost = () if state.ghost is None else _leading_to(state.ghost.snapshot.steps, pieces["ghost"])
        state = _with_pieces(state, _leading_to(state.run.snapshot.steps, pieces["run"]), ghost)
        try:
            room_of(record.settings.run)
        except BadSetting:
            # Such as a robot's file that this server was not started with.
            state = None
    return replace(record, state=state, recordings=recordings)


def _leading_to(steps: int, pieces: list[Recorded]) -> tuple[Recorded, ...]:
    """Newest pieces that end at `steps`, without a gap."""
    found: list[Recorded] = []
    for piece in reversed(pieces):
        if piece.snapshot.steps + piece.steps != steps:
            break
        steps = piece.snapshot.steps
        found.append(piece)
    return tuple(reversed(found))
