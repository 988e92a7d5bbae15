"""Duet in a notebook: `duet.show()` opens the page in a cell and returns the run that is seen there, as numbers.

One run a kernel: every cell that shows it shows the same one. It ends with the kernel, or by `duet.close()`.
"""

import atexit
from typing import Final

from app.jupyter.inline_page import inline_html
from app.jupyter.notebook_run import NotebookRun
from app.settings import Settings
from scenes.settings import changed

__all__ = ["close", "show"]

HEIGHT: Final = 720
"""Of the page in a cell [px]."""

_running: NotebookRun | None = None


def show(height: int = HEIGHT, **settings: object) -> NotebookRun:
    """Show the page below this cell and return its run; it is the same in every cell.

    Args:
        height: of the page [px].
        settings: as in a link, in SI units: `show(scene="ball", dm=0.1)`; `lwr-duet run --help` lists them. They change a run that is
            there already.

    Raises:
        BadSetting: a setting is not possible; nothing is changed, nor shown.
    """
    global _running
    from IPython.display import HTML, display
    from IPython.utils.capture import capture_output

    if _running is None:
        start = Settings()
        for key, value in settings.items():
            start = changed(start, key, value)
        # viser shows a box with its addresses, which are not those of the hub.
        with capture_output(stdout=False, stderr=False):
            _running = NotebookRun(start)
    elif settings:
        _running.change(**settings)
    display(HTML(inline_html(_running, height)))
    return _running


def close() -> None:
    """End the run and its page; the next `show` begins a new one."""
    global _running
    if _running is not None:
        _running.close()
        _running = None


atexit.register(close)
