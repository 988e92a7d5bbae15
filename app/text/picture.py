"""Pictures of a Markdown file, `![description](pictures/name.svg)` on their own lines."""

import base64
import errno
import html
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from scenes.files import path_inside, read_file

PICTURE: Final = re.compile(r"^[ \t]*!\[([^\]\n]*)\]\(([^)\n]*)\)[ \t]*$", re.MULTILINE)

MOST_BYTES: Final = 300_000

_KINDS: Final = {".svg": "image/svg+xml", ".png": "image/png"}
_PNG: Final = b"\x89PNG\r\n\x1a\n"
_SVG: Final = "{http://www.w3.org/2000/svg}"
_SHAPES: Final = frozenset(
    ("svg", "g", "path", "circle", "ellipse", "line", "rect", "polyline", "polygon", "text", "tspan")
)
_WORDS: Final = frozenset(("title", "desc"))


class NoPicture(Exception):
    """The page cannot show a picture; the message names the remedy."""


def picture_html(folder: Path, name: str, words: str) -> str:
    """A picture in or below a file's folder, embedded in a page: an SVG of shapes and text as an element in
    the page's colours, everything else as an `<img>`, in which nothing runs or loads.

    Raises:
        NoPicture: elsewhere, missing, too large or not a picture.
    """
    path, quoted = path_inside(folder, name), repr(name[:60])
    if path is None or path.suffix not in _KINDS:
        raise NoPicture(
            f"{quoted} is not a picture beside the lesson; it must be an .svg or .png in its folder or one below."
        )
    try:
        data = read_file(path, MOST_BYTES)
    except FileNotFoundError:
        raise NoPicture(f"there is no picture {quoted} beside the lesson.") from None
    except OSError as error:
        if error.errno == errno.EFBIG:
            raise NoPicture(
                f"the picture {quoted} is larger than {MOST_BYTES // 1000} kB; make it smaller."
            ) from None
        raise NoPicture(f"the picture {quoted} cannot be read ({error.strerror}).") from None
    if path.suffix == ".png" and not data.startswith(_PNG):
        raise NoPicture(f"the picture {quoted} is not a PNG; save it as one.")
    label = html.escape(words)
    if path.suffix == ".svg" and (svg := _plain(_root(data, quoted))):
        return svg.replace("<svg ", f'<svg class="picture" role="img" aria-label="{label}" ', 1)
    return f'<img alt="{label}" src="data:{_KINDS[path.suffix]};base64,{base64.b64encode(data).decode()}">'


def _root(data: bytes, quoted: str) -> ET.Element:
    try:
        root = ET.fromstring(data)
    except (ET.ParseError, ValueError) as error:
        raise NoPicture(f"the picture {quoted} is not an SVG: {error}.") from None
    if root.tag != f"{_SVG}svg":
        raise NoPicture(
            f'the picture {quoted} is not an SVG; begin it with <svg xmlns="{_SVG[1:-1]}" viewBox="…">.'
        )
    return root


def _plain(root: ET.Element) -> str:
    """An SVG as an element; "" if it contains more than shapes and text."""
    for element in list(root.iter()):
        for child in list(element):
            if str(child.tag).removeprefix(_SVG) in _WORDS:
                # The description is in the language of the text.
                element.remove(child)
    for element in root.iter():
        element.tag = str(element.tag).removeprefix(_SVG)
        attributes = element.attrib.items()
        if element.tag not in _SHAPES or any(_may_act(key, value) for key, value in attributes):
            return ""
    for key in ("width", "height", "class", "role"):
        root.attrib.pop(key, None)
    return ET.tostring(root, encoding="unicode") if root.get("viewBox") else ""


def _may_act(key: str, value: str) -> bool:
    """True if an attribute runs or loads something, or affects other elements."""
    return key.startswith(("on", "{")) or key in ("id", "style", "href") or "url(" in value


def picture_problems(line: str, folder: Path, alone: bool = True) -> Iterator[str]:
    if "![" not in line:
        return
    found = PICTURE.match(line)
    if found is None or not alone:
        yield "a picture, ![what is seen](name.svg), stands on a line of its own, in no title, list, answer or hint; move it there."
        return
    if not found[1].strip():
        yield f"the picture {found[2][:60]!r} says nothing to those who do not see it; write what is seen into the [ ]."
    try:
        picture_html(folder, found[2], found[1])
    except NoPicture as problem:
        yield str(problem)
