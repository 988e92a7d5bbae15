"""Checks of a served page."""

from app.web.headless_client import HeadlessClient


def has_arms(visitor: HeadlessClient) -> bool:
    return visitor.mirror.replayed and any(name.startswith("/arms/") for name in list(visitor.mirror.nodes))


def is_whole(visitor: HeadlessClient) -> bool:
    """True if a page has its arms and its keys."""
    return len(visitor.mirror.commands) >= 14 and any(
        name.endswith("/j7") for name in list(visitor.mirror.nodes)
    )
