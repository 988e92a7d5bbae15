"""What is seen while the page is on its way: our name and one line, in the page's colours and language."""

import json
from pathlib import Path

from app.languages.client import LOADING
from app.server.index import MARK
from app.settings import PageSettings


def loading_html(page: PageSettings) -> str:
    """Return what the page's body begins with.

    Args:
        page: theme and language, where the link asks for none.
    """
    given = {"__MARK__": MARK, "__THEME__": page.theme, "__LANGUAGE__": page.language, "__LOADING__": json.dumps(LOADING)}
    html = Path(__file__).with_suffix(".html").read_text(encoding="utf-8")
    for name, value in given.items():
        html = html.replace(name, value)
    return html
