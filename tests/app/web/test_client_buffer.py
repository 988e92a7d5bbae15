"""A browser's buffer sends the same messages as viser's, in the same order, with fewer wake-ups."""

import asyncio
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

from hypothesis import given
from hypothesis import strategies as st
from viser import _messages as viser_messages
from viser.infra._messages import Message

from app.web.sending import ClientBuffer
from app.web.viser_internals import MessageBuffer
from tests.app.web.conftest import in_a_loop


def made(kind: int, name: str, value: int) -> Message:
    match kind:
        case 0:
            return viser_messages.SetPositionMessage(name, (float(value), 0.0, 0.0))
        case 1:
            return viser_messages.SceneNodeUpdateMessage(name, {"color" if value % 2 else "opacity": value})
        case 2:
            return viser_messages.RemoveSceneNodeMessage(name)
        case 3:
            return viser_messages.GuiUpdateMessage(name, {"content": str(value)})
        case 4:
            return viser_messages.SetSceneNodeClickBindingsMessage(name, ())
        case 5:
            return viser_messages.GuiUpdateMessage(name, {"value": value})
        case _:
            return viser_messages.NotificationUpdateMessage(
                name, viser_messages.NotificationProps("a", "b", False, True, 1.0, None)
            )


Batch = list[tuple[int, str, int]]
pushed = st.lists(st.tuples(st.integers(0, 7), st.sampled_from("abc"), st.integers(0, 5)), max_size=30)


async def drained(made_in: Callable[..., MessageBuffer], batches: list[Batch]) -> list[Message]:
    """All messages sent to a browser; each batch is pushed atomically."""
    sent: list[Message] = []
    buffer = made_in(asyncio.get_running_loop())
    buffer.window_duration_sec = 0.0

    async def read() -> None:
        async for window in buffer.window_generator(1):
            assert len(window) <= buffer.max_window_size
            sent.extend(window)

    reader = asyncio.create_task(read())
    for batch in batches:
        with suppress(RuntimeError):
            buffer.atomic_start()
            for kind, name, value in batch:
                if kind == 7:
                    buffer.remove_entity_state_from_buffer("scene", name)
                else:
                    buffer.push(made(kind, name, value))
            await asyncio.sleep(0)
            buffer.atomic_end()
        for _ in range(20):
            await asyncio.sleep(0)
    buffer.set_done()
    await reader
    return sent


@given(st.lists(pushed, min_size=1, max_size=4))
def test_a_browser_gets_the_same_messages_as_from_viser(batches: list[Batch]) -> None:
    ours = in_a_loop(drained(ClientBuffer, batches))
    assert ours == in_a_loop(drained(partial(MessageBuffer, persistent_messages=False), batches))


def test_a_repeated_move_for_other_browsers_does_not_replace_our_answer() -> None:
    """viser repeats a dragged handle's place in the middle of a frame that has put the handle back."""
    repeated: Any = made(0, "/gizmo/hand", 2)
    repeated.excluded_self_client = 1
    answer = made(0, "/gizmo/hand", 1)

    async def work() -> list[Message]:
        buffer = ClientBuffer(asyncio.get_running_loop())
        windows = buffer.window_generator(1)
        for message in (answer, repeated):
            buffer.push(message)
        async with asyncio.timeout(10.0):
            sent = list(await anext(windows))
        buffer.set_done()
        await windows.aclose()
        return sent

    assert in_a_loop(work()) == [answer]


def test_a_frame_wakes_the_sender_once_and_an_idle_one_never() -> None:
    async def work() -> list[int]:
        loop, woken = asyncio.get_running_loop(), list[int]()
        buffer, calls = ClientBuffer(loop), 0
        call = loop.call_soon_threadsafe

        def count(*arguments: Any) -> Any:
            nonlocal calls
            calls += 1
            return call(*arguments)

        loop.call_soon_threadsafe = count  # type: ignore[method-assign]
        windows = buffer.window_generator(1)
        for batch in (range(200), range(3), ()):
            calls = 0
            buffer.atomic_start()
            for i in batch:
                buffer.push(made(0, f"/{i}", i))
            buffer.flush()
            buffer.atomic_end()
            buffer.flush()
            got = 0
            while got < len(batch):
                got += len(await anext(windows))
            woken.append(calls)
        # Also outside a frame: within `window_duration_sec`, one wake-up for all.
        calls = 0
        buffer.push(made(0, "/a", 1))
        buffer.push(made(0, "/b", 1))
        assert len(await anext(windows)) == 2
        woken.append(calls)
        buffer.set_done()
        buffer.push(made(0, "/late", 1))
        await windows.aclose()
        return woken

    first, second, idle, outside = in_a_loop(work())
    assert (first, second, idle, outside) == (1, 1, 0, 1)
