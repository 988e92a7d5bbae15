"""Choice of a server's port."""

import socket
from contextlib import ExitStack, suppress

import pytest

from app.web.listening import MOST_TRIED, PortInUse, listen_near


def test_the_next_free_port_is_taken() -> None:
    with ExitStack() as opened:
        first = opened.enter_context(socket.create_server(("127.0.0.1", 0))).getsockname()[1]
        near = opened.enter_context(listen_near("127.0.0.1", first))
        assert first < near.getsockname()[1] < first + MOST_TRIED
        for port in range(first + 1, first + MOST_TRIED):
            with suppress(OSError):
                opened.enter_context(socket.create_server(("127.0.0.1", port)))
        with pytest.raises(PortInUse):
            listen_near("127.0.0.1", first)
