"""The browsers that watch a lecture with the same look: what is drawn for them is packed once, and sent to them only."""

import viser

from app.settings import Look
from app.web.viser_internals import Message, ServerView


class Audience(ServerView):
    """What the browsers of one look see.

    Args:
        server: that the browsers are connected to.
        look: of their tabs.
        before: what every browser is sent first.

    Attributes:
        look: see above.
        watchers: client ids of the browsers; set by `app.web.audiences`.
    """

    def __init__(self, server: viser.ViserServer, look: Look, before: list[Message]) -> None:
        self.look = look
        self.watchers: set[int] = set()
        super().__init__(server, before)
