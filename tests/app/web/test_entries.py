"""An entry waits until its action is done, dropped or replaced; its control is not written meanwhile."""

from typing import Any

import pytest
import viser

from app.session.actions import ActionQueue, SetSetting
from app.web.entries import Entries
from tests.app.posted_call import NamedCall, PostedCall, do_call
from tests.app.web.conftest import Start
from tests.blocking_client import BlockingClient


def entered(
    entries: Entries, control: str, value: int, into: list[int], queue: ActionQueue | None = None
) -> None:
    """Process a message that enters a value; with a queue, an action applies it later."""
    with entries.taking(control, lambda: into.append(value)):
        if queue is not None:
            queue.put(NamedCall(control, lambda: into.append(10 * value)))


def test_an_entry_waits_until_its_action_is_done() -> None:
    entries, queue, done = Entries(), ActionQueue(do_call), list[int]()
    entries.deal(4)
    entered(entries, "a", 1, done, queue)
    assert entries.dealt_before("a") is None and entries.dealt_before("b") == 5 and done == []
    queue.put(PostedCall(lambda: done.append(7)))
    queue.do()
    # The control gets the value back before the action, which may write another one.
    assert done == [1, 10, 7] and entries.dealt_before("a") == 5


def test_an_entry_without_an_action_ends_at_once() -> None:
    entries, done = Entries(), list[int]()
    entered(entries, "a", 1, done)
    assert done == [1] and entries.dealt_before("a") == 1
    # Messages that were refused before count as well.
    entries.deal(3)
    assert entries.dealt_before("a") == 3


def test_a_newer_entry_still_waits_when_the_earlier_one_ends() -> None:
    entries, first, second, done = Entries(), ActionQueue(do_call), ActionQueue(do_call), list[int]()
    entered(entries, "a", 1, done, first)
    entered(entries, "a", 2, done, second)
    first.do()
    assert done == [10] and entries.dealt_before("a") is None
    second.do()
    assert done == [10, 2, 20] and entries.dealt_before("a") == 2


def test_a_replaced_or_dropped_action_ends_its_entry() -> None:
    entries, queue, done = Entries(), ActionQueue(do_call), list[int]()
    entered(entries, "a", 1, done, queue)
    queue.put(NamedCall("a", lambda: done.append(9)))
    assert done == [1] and entries.dealt_before("a") == 1
    entered(entries, "a", 2, done, queue)
    assert entries.dealt_before("a") is None
    queue.drop()
    assert done == [1, 2] and entries.dealt_before("a") == 2 and len(queue) == 0


def test_a_server_keeps_an_entered_value_and_counts_processed_messages(
    start: Start, monkeypatch: pytest.MonkeyPatch
) -> None:
    server, queue, stamps = start(), ActionQueue(do_call), list[tuple[float, int]]()
    with BlockingClient(server.url) as visitor:
        visitor.wait_for(lambda _: server.get_clients())
        (client,) = server.get_clients().values()
        slider = client.gui.add_slider("way", 0.0, 10.0, 1.0, 0.0)

        @slider.on_update
        async def _(event: viser.GuiEvent[Any]) -> None:
            if event.client_id is not None:
                queue.put(SetSetting("way", event.target.value))

        take = visitor.mirror.take

        def note(message: dict[str, Any]) -> None:
            if "after" in message:
                stamps.append((message["updates"]["value"], message["after"]))
            take(message)

        monkeypatch.setattr(visitor.mirror, "take", note)
        visitor.wait_for(lambda v: v.mirror.gui)
        # Out of range, so that it is refused.
        visitor.set_value("way", 50.0)
        visitor.set_value("way", 5.0)
        visitor.wait_for(lambda _: len(queue))
        slider.value = 3.0
        assert slider.value == 5.0
        queue.do()
        slider.value = 4.0
        visitor.wait_for(lambda _: stamps)
        # The camera was the first message.
        assert stamps == [(4.0, 3)]
