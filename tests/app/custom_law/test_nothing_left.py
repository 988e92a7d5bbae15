"""No process is left of a student's law, however it or the page ends."""

from __future__ import annotations

import gc
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from numpy.testing import assert_array_equal

from app.custom_law.custom_law import CustomLaw
from tests.app.custom_law.helpers import GOOD, SITUATION, ZEROS, gone, until, write


def test_no_process_is_left(file: Path) -> None:
    """After close, after a `with`, and when nothing refers to it any more; closing twice is closing once."""
    write(file, GOOD)
    law = CustomLaw(file, waits=True)
    law(SITUATION)
    pid = law.pid
    law.close()
    law.close()
    assert pid is not None and gone(pid)
    assert_array_equal(law(SITUATION), ZEROS)
    law.restart()
    assert law.pid is None and not law.refresh()
    forgotten = CustomLaw(file, waits=True)
    forgotten(SITUATION)
    pid = forgotten.pid
    del forgotten
    gc.collect()
    assert pid is not None and gone(pid)


@pytest.mark.parametrize("end", ["closed", "dead"])
def test_what_the_law_started_goes_with_it(file: Path, end: str) -> None:
    """When it is closed, and when it has gone by itself."""
    text = """
        import os, subprocess, sys
        child = subprocess.Popen([sys.executable, "-SE", "-c", "input()"], stdin=subprocess.PIPE)

        def law(s):
            if s.distance < 0:
                os._exit(0)
            return s.nominal * 0 + child.pid
    """
    with CustomLaw(write(file, text), waits=True) as law:
        grandchild = int(law(SITUATION)[0])
        assert not gone(grandchild)
        if end == "dead":
            law(SITUATION._replace(distance=-0.1))
            assert law.problem is not None and "exit code 0" in law.problem.text
            until(lambda: gone(grandchild))
    until(lambda: gone(grandchild))


@pytest.mark.parametrize("end", ["os.kill(os.getpid(), 9)", "sys.exit()"])
def test_it_goes_with_the_page(file: Path, end: str) -> None:
    """However the page's process ends, and even in the middle of an endless loop."""
    write(file, "while True: pass")
    page = f"""
        import os, sys
        from pathlib import Path
        from app.custom_law.child import Child
        from app.custom_law.wire import LoadFile, encode
        path = Path({str(file)!r})
        child = Child(path, 2**28)
        assert child.receive(60.0) is not None
        child.line.send_bytes(encode(LoadFile(path.read_bytes())))
        print(child.pid, flush=True)
        {end}
    """
    root = Path(__file__).parents[3]
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(page)], cwd=root, capture_output=True, text=True, timeout=120.0, check=False
    )
    assert done.stdout.strip().isdigit(), done.stderr
    until(lambda: gone(int(done.stdout)))
