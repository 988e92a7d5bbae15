"""The teacher's key: whoever opens the page with `?key=KEY` is a teacher."""

import secrets
from collections.abc import Mapping

WRONG_KEY = "This is not the teacher's key: you are here as a student. Whoever started Duet knows the link with the right one."


def is_teacher(key: str | None, query: Mapping[str, str]) -> bool:
    """Return whether a link carries the key; nobody's does where there is none."""
    return key is not None and secrets.compare_digest(query.get("key", "").encode(), key.encode())


def is_mistaken(key: str | None, query: Mapping[str, str]) -> bool:
    """Return whether a link carries a key, but another one."""
    return key is not None and bool(query.get("key")) and not is_teacher(key, query)
