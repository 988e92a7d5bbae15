"""Duet in a notebook, as `from lwr_duet import duet`.

One run per kernel, which every cell shows. It ends with the kernel, or by `duet.close()`.
"""

import atexit
import html
import secrets
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final
from urllib.parse import urlencode

from app.features.jupyter.cell_law import law_text
from app.features.jupyter.notebook_run import NotebookRun, all_changed
from app.i18n.catalogue import words_of
from app.i18n.speaking import N_
from app.settings import ALONE, LANGUAGES, Settings
from app.web.pages import PageAssets
from controllers.errors import BadSetting

SCRIPT: Final = Path(__file__).parent / "static" / "inline_page.js"

RUN_AGAIN: Final = N_("Run this cell to see Duet here.")
ENDED: Final = N_("This Duet has ended. Run the cell again.")
NO_PROXY: Final = N_(
    "This Jupyter cannot show Duet here: install jupyter-server-proxy where Jupyter runs, and start it again. On the computer where "
    "the kernel runs you can open Duet in a tab:"
)


def cell_html(server: NotebookRun, height: int) -> str:
    place = f"duet-{secrets.token_hex(8)}"
    texts = {
        language: {"ended": words_of(language)(ENDED), "noProxy": words_of(language)(NO_PROXY)}
        for language in LANGUAGES
    }
    inline = {
        "place": place,
        "port": server.port,
        "run": server.server_run,
        "query": urlencode({"key": server.key, ALONE: 1, "resume": secrets.token_hex(16)}),
        "height": height,
        "texts": texts,
    }
    # The sentence remains if Jupyter does not run the scripts of a notebook.
    return f'<div id="{place}">{html.escape(RUN_AGAIN)}</div>{PageAssets((SCRIPT,), constants={"inline": inline}).script_html()}'


__all__ = ["close", "law", "show"]

HEIGHT: Final = 720
"""Height of the page [px]."""

_running: NotebookRun | None = None


def show(
    height: int = HEIGHT, lesson: int | str | None = None, step: int = 1, **settings: object
) -> NotebookRun:
    """Show the page below this cell and return its run.

    A script calls it below `if __name__ == "__main__":`, as the run's other processes read the script again.

    Args:
        lesson: number or name.
        step: from 1.
        settings: in SI units, by link key or long name: `show(scene="ball", dm=0.1)`,
            `show(critical_distance=0.1)`; see `lwr-duet run --help`. They change an existing run.

    Raises:
        BadSetting: a setting, lesson or step is not possible; nothing is changed or shown.
    """
    global _running
    from IPython.display import HTML, display
    from IPython.utils.capture import capture_output

    if _running is None or _running.closed:
        start = all_changed(Settings(), settings)
        # viser shows a box with its addresses, which are not those of the hub.
        with capture_output(stdout=False, stderr=False):
            run = NotebookRun(start)
        try:
            if lesson is not None:
                run.find_lesson(lesson, step)
        except BadSetting:
            run.close()
            raise
        _running = run
    else:
        if lesson is not None:
            _running.find_lesson(lesson, step)
        if settings:
            _running.change(**settings)
    if lesson is not None:
        _running.open_lesson(lesson, step)
    display(HTML(cell_html(_running, height)))
    return _running


def law(function: Callable[[Any], Any] | None, height: int = HEIGHT) -> NotebookRun:
    """Run a function as the law, with the paper's as the ghost, and show the page; return the run.

    Args:
        function: `law(situation)` → joint velocities; see `lwr-duet new-law`. It runs in its own process,
            with its modules, numbers and functions from the notebook. None restores the law of the settings.

    Raises:
        BadSetting: not a function written with def.
    """
    text = None if function is None else law_text(function)
    run = show(height)
    run.take_law(text)
    return run


def close() -> None:
    """End the run and its page; the next `show` begins a new one."""
    global _running
    if _running is not None:
        _running.close()
        _running = None


atexit.register(close)
