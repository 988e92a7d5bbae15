"""What is seen while the page is on its way: our name and one line, in the page's colours and language."""

import json

from app.i18n.client_texts import LOADING
from app.page import STATIC
from app.settings import PageSettings
from app.web.index_page import MARK


def loading_html(page: PageSettings) -> str:
    """Return what the page's body begins with.

    Args:
        page: theme and language, where the link asks for none.
    """
    given = {"__MARK__": MARK, "__THEME__": page.theme, "__LANGUAGE__": page.language, "__LOADING__": json.dumps(LOADING)}
    html = (STATIC / "loading.html").read_text(encoding="utf-8")
    for name, value in given.items():
        html = html.replace(name, value)
    return html
