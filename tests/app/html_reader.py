"""Tags, links and text of a piece of HTML."""

from html.parser import HTMLParser

VOID = {"br", "hr", "img", "meta", "path", "rect", "circle", "line", "use", "polyline", "ellipse"}


class HtmlReader(HTMLParser):
    """Reads a piece of HTML; fails if a tag is not closed, or closed in the wrong order."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self._open: list[str] = []
        self.tags: set[str] = set()
        self.links: set[str] = set()
        self.text = ""
        self.feed(html)
        self.close()
        assert not self._open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.links |= {value or "" for name, value in attrs if name in ("href", "src")}
        if tag not in VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)

    def handle_endtag(self, tag: str) -> None:
        assert tag in VOID or self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        # A number and its unit have a no-break space between them.
        self.text += data.replace("\u00a0", " ")
