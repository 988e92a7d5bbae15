"""A student's law is reloaded when its file is saved, and not otherwise."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from app.custom_law import custom_law as custom_law_module
from app.custom_law.custom_law import CustomLaw
from tests.app.custom_law.helpers import GOOD, SHORT, SITUATION, gone, soon, until, write


@pytest.fixture
def eager(monkeypatch: pytest.MonkeyPatch) -> None:
    """The file is looked at whenever `refresh` is called."""
    monkeypatch.setattr(custom_law_module, "LOOK", 0.0)


ENDLESS = "def law(s):\n    while True: pass"


@pytest.mark.usefixtures("eager")
def test_it_is_reloaded_on_save(file: Path) -> None:
    """The arm does what the file says, and the problem goes when it works again."""
    with CustomLaw(write(file, GOOD), SHORT) as law:
        pids: set[int | None] = set()

        def moves(factor: float, says: str) -> bool:
            law.refresh()
            pids.add(law.pid)
            works = law.problem is None if not says else law.problem is not None and says in law.problem.text
            return bool(np.array_equal(soon(law), SITUATION.nominal * factor)) and works

        saves = ((GOOD, 2, ""), (GOOD.replace("2", "3.5"), 3.5, ""), ("def law(s)\n", 0, "SyntaxError"), (ENDLESS, 0, "endless"))
        for number, (text, factor, says) in enumerate((*saves, ("# Now it is right.\n" + GOOD, 2, ""))):
            # Some editors write into the file, others put a new one in its place.
            if number % 2:
                os.replace(write(file.with_suffix(".tmp"), text), file)
            else:
                write(file, text)
            until(partial(moves, factor, says))
        assert len(pids - {None}) == 5
        assert [pid for pid in pids if pid is not None and not gone(pid)] == [law.pid]


@pytest.mark.usefixtures("eager")
def test_files_that_are_no_news(file: Path) -> None:
    # The same text saved again, and a file that is away for a moment, as some editors have it, leave the process alone.
    with CustomLaw(write(file, GOOD), waits=True) as law:
        law(SITUATION)
        pid = law.pid
        assert not law.refresh()
        os.utime(file, ns=(1, 1))
        assert not law.refresh()
        file.unlink()
        assert not law.refresh() and not law.away
        assert_array_equal(law(SITUATION), SITUATION.nominal * 2)
        while not law.away:
            assert not law.refresh()
        assert_array_equal(law(SITUATION), SITUATION.nominal * 2)
        write(file, GOOD)
        assert not law.refresh() and law.pid == pid and not law.away
        file.unlink()
        file.mkdir()
        assert law.refresh() and law.problem is not None and "cannot be read" in law.problem.text
        file.rmdir()
        write(file, GOOD)
        assert law.refresh()
        assert_array_equal(law(SITUATION), SITUATION.nominal * 2)
    # A session that has the law but never uses it costs nothing; a file that is saved meanwhile counts when it does.
    with CustomLaw(write(file, "def law(s)")) as law:
        write(file, GOOD)
        assert law.refresh() and law.pid is None and not law.ready and law.problem is None
        until(lambda: np.any(soon(law)))


def test_the_file_is_not_looked_at_all_the_time(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """At most every 0.5 s, however often it is asked."""
    looks: list[float] = []
    now = 100.0
    monkeypatch.setattr(custom_law_module, "monotonic", lambda: now)
    with CustomLaw(write(file, GOOD)) as law:
        monkeypatch.setattr(custom_law_module, "_stamp", lambda path: looks.append(now))
        for i in range(100):
            now = 100.0 + 0.02 * i
            law.refresh()
    assert len(looks) == 3 and min(np.diff(looks)) >= 0.5


def test_a_large_file_is_loaded(file: Path) -> None:
    """Larger than the buffer of a socket."""
    with CustomLaw(write(file, "#" * 900_000 + "\n" + GOOD)) as law:
        until(lambda: np.array_equal(soon(law), SITUATION.nominal * 2))


@pytest.mark.usefixtures("eager")
def test_a_broken_file_is_noticed_while_nothing_moves_and_so_is_a_mended_one(file: Path) -> None:
    """Paused, when no step calls the law, the message comes, changes and goes all the same."""
    with CustomLaw(write(file, GOOD), SHORT) as law:
        until(lambda: np.any(soon(law)))

        def is_said(says: str) -> bool:
            return not law.refresh() and (says in law.problem.text if law.problem else law.ready and not says)

        fails = "# It can be read now.\ndef law(s):\n    return s.nominal / 0 + undefined"
        for text, says in (("def law(s)", "line 1"), (fails, "line 3"), (GOOD, ""), (ENDLESS, "endless loop")):
            write(file, text)
            until(partial(is_said, says))
