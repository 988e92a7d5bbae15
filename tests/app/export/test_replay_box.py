"""What is typed beside the scrubber wins over the moment that the replay writes there; `test_bar.py` types in a browser."""

from __future__ import annotations

from app.bench.blocking_client import BlockingClient
from app.hosting.private_host import PrivateHost
from app.page.replay_box import KEY, MODIFIER
from tests.app.conftest import OpenHouse, ask

BOX = "moment [s]"


def box(visitor: BlockingClient) -> float:
    """What the server has written into the visitor's box."""
    return float(visitor.mirror.labelled(BOX)["value"])


def test_a_moment_that_is_typed_stands_in_the_box_and_the_replay_rests(house: OpenHouse) -> None:
    opened = house()
    with BlockingClient(opened.url) as visitor:
        host = opened.host
        assert isinstance(host, PrivateHost)
        visitor.wait_for(lambda _: len(host.sessions) == 1)
        (stand,) = list(host.visitors.values())
        session, bar = stand.session, stand.operation._keep
        assert bar is not None
        visitor.wait_for(lambda _: session.simulation.time > 0.8)
        ask(session, lambda s: (s.change("speed", 0.25), bar._watch()))
        visitor.wait_for(lambda _: bar.shelf.replay is not None and bar.shelf.replay.time > 0.1)
        replay = bar.shelf.replay
        assert replay is not None and replay.playing
        visitor.wait_for(lambda _: box(visitor) > 0.05)
        visitor.set_value(BOX, 0.5)
        # A browser shows what came last: the running moment may have been on its way to it when the value left.
        visitor.wait_for(lambda _: abs(box(visitor) - 0.5) < 1e-9)
        assert not replay.playing and abs(replay.time - 0.5) < 1e-9
        ask(session, lambda _: replay.toggle())
        visitor.wait_for(lambda _: box(visitor) > 0.52)
        (key,) = [c for c in visitor.mirror.commands.values() if c.get("hotkey") == KEY and c.get("modifier") == MODIFIER]
        visitor.send({"type": "CommandTriggerMessage", "uuid": key["uuid"]})
        visitor.wait_for(lambda _: not replay.playing and abs(box(visitor) - replay.time) < 0.006)
