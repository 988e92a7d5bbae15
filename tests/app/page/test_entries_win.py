"""A visitor's entry wins over a value that the server writes into the same control: slow line, slow frame."""

import socket
import socketserver
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress

import numpy as np
import pytest
from playwright.sync_api import Locator, Page

from app.session.replay import Replay
from app.session.session import Session
from scenes.targets import JointTarget
from tests.app.conftest import OpenHouse, ask
from tests.app.page.by_hand import control, row_of, visit
from tests.browser import PageAt, until


class SlowLine(socketserver.ThreadingTCPServer):
    """Connection to a server that holds the browser's messages back while `open` is not set."""

    allow_reuse_address = daemon_threads = True

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), _Line)
        self.behind, self.open = 0, threading.Event()
        self.open.set()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_address[1]}"


class _Line(socketserver.BaseRequestHandler):
    def handle(self) -> None:
        line = self.server
        assert isinstance(line, SlowLine)
        with socket.create_connection(("127.0.0.1", line.behind)) as behind, suppress(OSError):
            threading.Thread(target=self._hand_back, args=(behind,), daemon=True).start()
            while data := self.request.recv(65536):
                line.open.wait()
                behind.sendall(data)

    def _hand_back(self, behind: socket.socket) -> None:
        with suppress(OSError):
            while data := behind.recv(65536):
                self.request.sendall(data)
            self.request.shutdown(socket.SHUT_RDWR)


@pytest.fixture
def line() -> Iterator[SlowLine]:
    with SlowLine() as made:
        threading.Thread(target=made.serve_forever, args=(0.01,), daemon=True).start()
        yield made
        made.open.set()
        made.shutdown()


def box(row: Locator) -> Locator:
    return row.locator("input[type=text]").last


def sees_changes(page: Page, shown: Callable[[], str], what: str) -> None:
    """Wait until the shown text has changed twice."""
    seen = {shown()}
    until(page, lambda: len(seen) > 2 or seen.add(shown()), what)


@pytest.mark.thorough
def test_entries_on_a_slow_line_in_a_setting_a_joint_and_a_replay(
    house: OpenHouse, page_at: PageAt, line: SlowLine
) -> None:
    page = page_at(900, 640)
    opened = house()
    line.behind = opened.server.get_port()
    session = visit(page, opened, "picture=fast&dm=0.1&n=1", line.url)
    d_m, n = (box(control(page, key)) for key in ("dm", "n"))
    line.open.clear()
    d_m.fill("250")
    ask(session, lambda s: [s.change("dm", 0.2), s.change("n", 3.0)])
    until(page, lambda: n.input_value() == "3", "what the server writes")
    assert d_m.input_value() == "250"
    line.open.set()
    until(page, lambda: session.settings.run.law.critical_distance == pytest.approx(0.25), "what was entered")
    # A later value from the server is newer than the entry.
    ask(session, lambda s: s.change("n", 4.0))
    until(page, lambda: n.input_value() == "4", "a later value")
    assert d_m.input_value() == "250"
    ask(session, lambda s: s.change("dm", 0.15))
    until(page, lambda: d_m.input_value() == "150", "a later value of the same control")
    # An emptied box shows the current value again.
    for emptied, value in ((n, "4"), (d_m, "150")):
        emptied.fill("")
        emptied.press("Tab")
        until(page, lambda emptied=emptied, value=value: emptied.input_value() == value, "the number again")
    assert (
        session.settings.run.law.order == 4.0
        and session.settings.run.law.critical_distance == pytest.approx(0.15)
    )

    see_a_joint_of_an_arm_that_moves(page, session, line)
    see_a_moment_of_a_replay_that_plays(page, session, line)


def see_a_joint_of_an_arm_that_moves(page: Page, session: Session, line: SlowLine) -> None:
    """A joint's slider, and the box with its angle, which has the focus."""
    ask(session, lambda s: s.change("scene", "master_slave"))
    page.get_by_role("tab", name="Arms").click()
    page.get_by_text("your arm's joints [°]").click()
    arm = session.simulation.guided
    first, other = (box(row_of(page, label)) for label in arm.labels[:2])
    first.wait_for()
    # The selection stays while the arm moves, and the first key replaces it.
    first.evaluate("e => { e.focus(); e.select(); }")
    sees_changes(page, other.input_value, "the other sliders follow the arm")
    # After a second without a value, the next one is written first, and then selected.
    whole = "e => e.selectionStart === 0 && e.selectionEnd === e.value.length"
    until(page, lambda: first.evaluate(whole), "what is selected stays so")
    # A box without the focus shows the missed values.
    first.evaluate("e => e.blur()")
    sees_changes(page, first.input_value, "the box that is left follows the arm, too")

    line.open.clear()
    first.fill("12.5")
    sees_changes(page, other.input_value, "the other sliders follow the arm")
    assert first.input_value() == "12.5"
    line.open.set()
    until(page, lambda: isinstance(session.held, JointTarget), "the arm is led by its joints")

    ask(session, lambda s: s.control.hurry(s.simulation.time + 10.0))

    def there(s: Session) -> bool:
        return abs(np.degrees(s.simulation.positions[arm.joints][0]) - 12.5) < 0.5

    until(page, lambda: ask(session, there), "the joint where it was typed")
    assert first.input_value() == "12.5"


def see_a_moment_of_a_replay_that_plays(page: Page, session: Session, line: SlowLine) -> None:
    # Slow speed, and a long run, so that the replay does not end before this test.
    ask(session, lambda s: [s.change("scene", "hold"), s.change("speed", 0.5), s.control.hurry(12.0)])
    until(page, lambda: session.simulation.time > 12.0, "something to look back at")
    page.get_by_text("Keep and replay").click()
    page.get_by_role("button", name="Watch").click()
    player = session.player

    def replay() -> Replay:
        # The complete replay replaces that of the newest 20 s once it is computed.
        assert player.replay is not None
        return player.replay

    def from_the_beginning(_: Session) -> float:
        replay().seek(0.0)
        replay().playing = True
        return replay().begin

    until(page, lambda: player.replay is not None, "the past")
    moment = box(row_of(page, "moment [s]"))
    moment.wait_for()
    shown = page.get_by_text("the past: ")
    shown.wait_for()
    entered = round(ask(session, from_the_beginning) + 0.55, 2)
    line.open.clear()
    moment.fill(f"{entered:g}")
    begin = replay().time
    until(page, lambda: replay().time > begin + 0.5, "the replay goes on")
    sees_changes(page, shown.inner_text, "what the server writes")
    assert moment.input_value() == f"{entered:g}"
    line.open.set()
    until(
        page,
        lambda: not replay().playing and replay().time == pytest.approx(entered),
        "the moment that was typed",
    )
    assert moment.input_value() == f"{entered:g}"
