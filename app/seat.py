"""One browser in a lecture: whose it is, and what it has beside the stage."""

from dataclasses import dataclass

import viser

from app.page.teacher import TeacherPanel
from app.page.teacher_answers import Answers, Banner
from app.page.view import View
from app.stand import Stand


@dataclass
class Seat:
    """One browser.

    Attributes:
        client, query: as it came.
        who: the word that its tab keeps, or one of ours if it keeps none.
        lasting: whether the word outlives a reload.
        screen: whether it only shows (a projector), and is no student's.
        teacher: whether it brought the key.
        narrow: whether its window has no room for everything beside each other.
        banner, answers, panel: what it has beside the stage; None for what it has not.
        stand: its own session; None while it sees the stage.
        view: what the banner stands on; another one in another language.
        moved: whether it was asked to come again.
        shown: what the banner and the answers were made of.
    """

    client: viser.ClientHandle
    query: dict[str, str]
    who: str
    lasting: bool
    screen: bool
    teacher: bool
    narrow: bool
    banner: Banner | None = None
    answers: Answers | None = None
    panel: TeacherPanel | None = None
    stand: Stand | None = None
    view: View | None = None
    moved: bool = False
    shown: object = None


def origin_of(client: viser.ClientHandle) -> str:
    """Return the page's own address as a visitor's browser reached it; "" if it did not say."""
    connection = client._viser_server._websock_server._live_connections.get(client.client_id)
    if connection is None or connection.request is None:
        return ""
    return str(connection.request.headers.get("Origin", ""))[:300]
