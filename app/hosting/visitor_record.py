"""A visitor's record, found by the tab's id."""

import logging
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final, TypeVar

import msgspec

from app.session.session_state import SessionState
from app.settings import LANGUAGES_KEY, MOTION, OPENED, PANEL, Settings
from scenes.inputs import Recorded

log = logging.getLogger("duet.store")

P = TypeVar("P")

_TAB_ID: Final = re.compile(r"^[a-z0-9]{16,64}$")

_OF_THE_TAB: Final = ("resume", "window", "key", MOTION, OPENED, LANGUAGES_KEY, PANEL)
"""Keys of the tab and its visitor."""


def tab_id(query: Mapping[str, str]) -> str | None:
    """Id in the tab's storage; None if missing or invalid."""
    word = query.get("resume", "")
    return word if _TAB_ID.match(word) else None


def same_tab(query: Mapping[str, str], other: Mapping[str, str]) -> bool:
    return tab_id(query) is not None and tab_id(query) == tab_id(other) and link_of(query) == link_of(other)


def link_of(query: Mapping[str, str]) -> dict[str, str]:
    """Parts of a query that decide what is shown."""
    return {key: value for key, value in query.items() if key not in _OF_THE_TAB}


@dataclass(frozen=True)
class VisitorRecord:
    """A visitor's saved work, as immutable plain data.

    Attributes:
        state: None if the session cannot continue.
        parts: of features, by name.
        recordings: runs of these parts, by name; see `app.session.parts.SessionPart.recordings`.
    """

    query: Mapping[str, str]
    settings: Settings
    state: SessionState | None = None
    parts: Mapping[str, bytes] = field(default_factory=dict)
    recordings: Mapping[str, Recorded] = field(default_factory=dict)


def with_part(record: VisitorRecord, name: str, part: object) -> VisitorRecord:
    """Record with a feature's part (plain data) replaced; None removes it."""
    others = {key: value for key, value in record.parts.items() if key != name}
    added = {} if part is None else {name: msgspec.msgpack.encode(part)}
    return replace(record, parts={**others, **added})


def part_of(record: VisitorRecord, name: str, kind: type[P]) -> P | None:
    """A feature's part; None without one of this type."""
    content = record.parts.get(name)
    if content is None:
        return None
    try:
        return msgspec.msgpack.decode(content, type=kind)
    except msgspec.MsgspecError as error:
        log.warning("the part “%s” of a record cannot be read (%s)", name, str(error)[:120])
        return None
