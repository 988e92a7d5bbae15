"""What a teacher is shown of the server: frames a second, sessions, load."""

from typing import NamedTuple

from app.i18n.speaking import tr


class ServerLoad(NamedTuple):
    """How busy a server is.

    Attributes:
        frames: a second, of every page.
        sessions: that had a frame lately: neither resting nor out of sight.
        places: sessions that it carries at 20 frames a second.
        load: part of what it carries [%]; beyond 100 all pages have fewer than 20 frames a second.
    """

    frames: int
    sessions: int
    places: int
    load: int


def load_pills(load: ServerLoad) -> list[tuple[str, str]]:
    """Return the server's numbers as pills: kind and words."""
    return [
        ("", tr("frames/s: {count}", count=load.frames)),
        ("", tr("sessions at work: {count} of {places}", count=load.sessions, places=load.places)),
        ("halt" if load.load > 100 else "go", tr("load: {percent} %", percent=load.load)),
    ]
