"""Load of the server, for a teacher."""

from typing import NamedTuple

from app.i18n.speaking import tr


class ServerLoad(NamedTuple):
    """Load of a server.

    Attributes:
        frames: per second, of every page.
        sessions: neither resting nor hidden.
        places: sessions that it can serve at 20 frames per second.
        load: share of its capacity [%]; beyond 100 all pages have fewer than 20 frames per second.
    """

    frames: int
    sessions: int
    places: int
    load: int


def load_pills(load: ServerLoad) -> list[tuple[str, str]]:
    return [
        ("", tr("frames/s: {count}", count=load.frames)),
        ("", tr("sessions at work: {count} of {places}", count=load.sessions, places=load.places)),
        ("halt" if load.load > 100 else "go", tr("load: {percent} %", percent=load.load)),
    ]
