"""Visits leave no objects and no log lines behind, and a page at rest receives nothing."""

import gc
import os
import threading
import weakref

import pytest

from app.page.panels import readout
from app.session.session import Session
from tests.app.conftest import HAND, Arrive, OpenHouse, live_sessions
from tests.blocking_client import BlockingClient
from tests.tools.monkey.visitor import assert_sound


@pytest.mark.skipif(not os.path.isdir("/proc/self/fd"), reason="counts through /proc, which only Linux has")
def test_visits_leave_no_objects_and_no_log_lines_behind(
    house: OpenHouse, arrive: Arrive, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Weak references: gc.get_objects() breaks a tuple(generator) that another thread is evaluating.
    sessions, begin = weakref.WeakSet[Session](), Session.__init__

    def remembered(session: Session, *args: object, **options: object) -> None:
        sessions.add(session)
        begin(session, *args, **options)  # pyright: ignore[reportArgumentType]

    monkeypatch.setattr(Session, "__init__", remembered)
    opened = house()

    def visit(number: int) -> None:
        with BlockingClient(opened.url, query=f"seed={number}&gizmo=1") as visitor:
            visitor.wait_for(lambda v: HAND in v.mirror.nodes)
            if number % 3 == 0:
                visitor.move_gizmo(HAND, phase="start")

    def count() -> tuple[int, int, int, int]:
        gc.collect()
        drags = opened.server.scene._active_transform_drag_handles
        return len(os.listdir("/proc/self/fd")), threading.active_count(), len(drags), len(sessions)

    def alone(_: Session) -> bool:
        return opened.server.count_clients() == 1 and set(live_sessions(opened)) == {witness.number}

    witness = arrive(opened)
    visit(0)
    witness.wait(alone)
    witness.run_on(0.05)
    before = count()
    # The remains of all visits are counted together; two visitors leave during a drag.
    for number in range(6):
        visit(number)
    witness.wait(alone)
    # Local variables of the frame loop may hold the last one until the next frame.
    witness.run_on(0.1)
    # A socket of the last one may be closed a little later.
    witness.wait(
        lambda _: all(now <= then for now, then in zip(count(), (*before[:3], before[3] + 1), strict=True))
    )
    assert witness.session.settings.page.autopilot and witness.session.held is None
    witness.ask(assert_sound)
    assert [record.getMessage() for record in caplog.records if record.exc_info] == []


def test_an_idle_frame_sends_nothing(
    house: OpenHouse, arrive: Arrive, monkeypatch: pytest.MonkeyPatch
) -> None:
    built, status_html = list[str](), readout.status_html
    monkeypatch.setattr(readout, "status_html", lambda *given: built.append("status") or status_html(*given))
    one = arrive(house(), "plot=laws")
    one.ask(lambda s: s.control.halt.set("visitor"))
    for scene, ghost in (("hold", "frozen"), ("ball", "off"), ("imitation", "off")):
        one.ask(lambda s, scene=scene, ghost=ghost: [s.change("scene", scene), s.change("ghost", ghost)])
        # Plots, link and numbers have different periods, so that the last one is sent a little later.
        quiet, frames, numbers = 0, -1, 0
        for _ in range(400):
            one.ask(lambda s: s.simulation.steps)
            quiet = quiet + 1 if (one.visitor.received.frames, len(built)) == (frames, numbers) else 0
            frames, numbers = one.visitor.received.frames, len(built)
            if quiet == 40:
                break
        assert quiet == 40 and numbers > 0, scene
        # A change is sent: the page was silent, not broken.
        one.ask(lambda s: s.change("n", s.settings.run.law.order + 1.0))
        one.visitor.wait_for(lambda v, frames=frames: v.received.frames > frames)
