"""The output of a cell that shows the page: a frame that finds its way through Jupyter's own address."""

import html
import secrets
from pathlib import Path
from typing import Final, Protocol
from urllib.parse import urlencode

from app.i18n.catalogue import words_of
from app.i18n.speaking import N_
from app.settings import ALONE, Language
from app.web.page_assets import PageAssets

SCRIPT: Final = Path(__file__).parent / "static" / "inline_page.js"

RUN_AGAIN: Final = N_("Run this cell to see Duet here.")
ENDED: Final = N_("This Duet has ended. Run the cell again.")
NO_PROXY: Final = N_(
    "This Jupyter cannot show Duet here: install jupyter-server-proxy where Jupyter runs, and start it again. On the computer where "
    "the kernel runs you can open Duet in a tab:"
)

_LANGUAGES: Final[tuple[Language, ...]] = ("en", "de", "sl")


class OpenServer(Protocol):
    """The server of a page; see `app.jupyter.notebook_run.NotebookRun`."""

    key: str

    @property
    def port(self) -> int:
        """Where it listens."""
        ...

    @property
    def server_run(self) -> str:
        """Its random word."""
        ...


def inline_html(server: OpenServer, height: int) -> str:
    """Return the output of a cell. `height`: of the page [px]."""
    place = f"duet-{secrets.token_hex(8)}"
    texts = {language: {"ended": words_of(language)(ENDED), "noProxy": words_of(language)(NO_PROXY)} for language in _LANGUAGES}
    inline = {
        "place": place,
        "port": server.port,
        "run": server.server_run,
        "query": urlencode({"key": server.key, ALONE: 1, "resume": secrets.token_hex(16)}),
        "height": height,
        "texts": texts,
    }
    # The sentence is what is left of the output where Jupyter does not run the scripts of a notebook.
    return f'<div id="{place}">{html.escape(RUN_AGAIN)}</div>{PageAssets((SCRIPT,), constants={"inline": inline}).script_html()}'
