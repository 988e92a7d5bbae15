"""Scripts and style sheets of a page: files that are joined in order, with the constants that they read from `window.duet`."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from app.i18n.client_texts import SOFTWARE, translations

STATIC: Final = Path(__file__).parent / "static"


@dataclass(frozen=True)
class PageAssets:
    """Files of a page.

    Attributes:
        scripts: JavaScript files, run in this order.
        styles: CSS files.
        constants: properties of `window.duet`, as JSON can hold them.
    """

    scripts: tuple[Path, ...] = ()
    styles: tuple[Path, ...] = ()
    constants: Mapping[str, object] = field(default_factory=dict)

    def __add__(self, other: PageAssets) -> PageAssets:
        """Return the files of both, the other's last."""
        return PageAssets(self.scripts + other.scripts, self.styles + other.styles, {**self.constants, **other.constants})

    def style_html(self) -> str:
        """Return one <style> element."""
        return f"<style>{_joined(self.styles)}</style>"

    def script_html(self) -> str:
        """Return one <script> element, which sets `window.duet` if there are constants, and runs every file in strict mode."""
        constants = json.dumps(self.constants, ensure_ascii=False).replace("<", "\\u003c")
        first = f"window.duet = {constants};\n" if self.constants else ""
        return f'<script>"use strict";\n{first}{_joined(self.scripts)}</script>'


NO_ASSETS: Final = PageAssets()


def _joined(files: tuple[Path, ...]) -> str:
    return "".join(file.read_text(encoding="utf-8") for file in files)


def translation() -> PageAssets:
    """Return what translates the texts that the browser says by itself."""
    return PageAssets((STATIC / "translation.js",), constants={"translations": translations()})


def software_rendering() -> PageAssets:
    """Return what says that the browser draws without a graphics card; it needs `translation`, and the window's event `duet-built`."""
    return PageAssets(
        (STATIC / "software_rendering.js",), (STATIC / "software_rendering.css",), constants={"softwareNote": SOFTWARE}
    )
