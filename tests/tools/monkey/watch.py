"""What must never happen, and everything that hears of it."""

from __future__ import annotations

import logging
import threading
import traceback
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from app.session.session import Session
from scenes.settings import changed, values


class Trouble(AssertionError):
    """Something that must never happen."""


class Watch(logging.Handler):
    """Everything that went wrong, on the page or at the server."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.complaints: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        trace = "".join(traceback.format_exception(*record.exc_info)) if record.exc_info else ""
        self.complaints.append(f"server's log: {record.name}: {record.getMessage()}\n{trace}")

    def take_thread(self, what: threading.ExceptHookArgs) -> None:
        self.complaints.append(
            f"a thread ended: {''.join(traceback.format_exception(what.exc_type, what.exc_value, what.exc_traceback))}"
        )

    def check(self) -> None:
        if self.complaints:
            raise Trouble("\n".join(self.complaints))


@contextmanager
def watching() -> Iterator[Watch]:
    """Note every error of the program while open."""
    watch, before = Watch(), threading.excepthook
    logging.getLogger().addHandler(watch)
    threading.excepthook = watch.take_thread
    try:
        yield watch
    finally:
        threading.excepthook = before
        logging.getLogger().removeHandler(watch)


def assert_sound(session: Session) -> None:
    """All that moves is and was where it can be, and every setting is one that can be set.

    Raises:
        Trouble: not so.
    """
    for who, simulation in (("run", session.simulation), ("ghost", session.ghost)):
        if simulation is None:
            continue
        model, table = simulation.room.model, simulation.history.table()
        q, dq = simulation.history.positions(table)[-400:], simulation.velocities
        if not (np.isfinite(q).all() and np.isfinite(dq).all() and np.isfinite(simulation.positions).all()):
            raise Trouble(f"{who}: not finite: {simulation.positions}, {dq}")
        low, high = model.lowerPositionLimit - 1e-9, model.upperPositionLimit + 1e-9
        for place in (*q, simulation.positions):
            if not ((place >= low).all() and (place <= high).all()):
                raise Trouble(f"{who}: out of its bounds by {np.maximum(low - place, place - high).max():.3g}: {place}")
    for key, value in values(session.settings).items():
        if changed(session.settings, key, value) != session.settings:
            raise Trouble(f"{key} = {value!r} is no value of a setting")
