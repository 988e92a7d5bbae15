"""Two fonts for browser tests, one wide and one narrow, independent of the machine's fonts.

Both are made from matplotlib's data. Wide: DejaVu Sans, the only font of a fresh Debian or Ubuntu. Narrow:
the same letters with the widths of Helvetica, like Arial and Liberation Sans; Noto Sans is between them.
"""

import atexit
import os
from functools import cache
from pathlib import Path
from shutil import copyfile
from tempfile import TemporaryDirectory
from typing import Final, Literal
from xml.sax.saxutils import escape

import matplotlib
from fontTools.afmLib import AFM
from fontTools.agl import toUnicode
from fontTools.pens.recordingPen import DecomposingRecordingPen
from fontTools.pens.transformPen import TransformPen
from fontTools.pens.ttGlyphPen import TTGlyphPen
from fontTools.ttLib import TTFont

Font = Literal["wide", "narrow"]
FONTS: Final[tuple[Font, Font]] = ("wide", "narrow")
"""Fonts in which every page must have a good layout."""

_DATA: Final = Path(matplotlib.get_data_path()) / "fonts"
_FACES: Final = {"": "phvr8a", "-Bold": "phvb8a"}
"""Suffix of DejaVu Sans' file name → Adobe Font Metrics file of Helvetica. Browsers make the italics."""
_FAMILY: Final[dict[Font, str]] = {"wide": "DejaVu Sans", "narrow": "Duet Narrow"}
_OF_DESIGN: Final = ("GPOS", "GSUB", "GDEF", "kern", "fpgm", "prep", "cvt ", "hdmx", "LTSH", "VDMX")
"""Tables that are wrong for letters of other widths: kerning, ligatures, hints."""
_LETTERS: Final = (*range(0x20, 0x250), *range(0x370, 0x400))
"""Narrowed code points: Latin and Greek. Machines take other signs from another font."""

_CONFIG: Final = """<?xml version="1.0"?>
<!DOCTYPE fontconfig SYSTEM "urn:fontconfig:fonts.dtd">
<fontconfig>
  <dir>{folder}</dir>
  <cachedir>{folder}/cache</cachedir>
  <match target="pattern"><edit name="family" mode="append_last"><string>{family}</string></edit></match>
  {aliases}
</fontconfig>
"""
_ALIAS: Final = (
    '<alias binding="same"><family>{name}</family><prefer><family>{family}</family></prefer></alias>'
)
_SANS: Final = ("sans-serif", "sans", "serif", "system-ui", "Arial", "Helvetica")
_MONO: Final = ("monospace", "ui-monospace")


def font_environment(font: Font) -> dict[str, str]:
    """Environment of a browser with this font as its only sans-serif. Has no effect outside Linux."""
    return {**os.environ, "FONTCONFIG_FILE": str(_configuration(font))}


@cache
def _configuration(font: Font) -> Path:
    """Path of a fontconfig file; it and the fonts are removed at the end of this process."""
    temporary = TemporaryDirectory(prefix="duet-fonts-", ignore_cleanup_errors=True)
    atexit.register(temporary.cleanup)
    folder = Path(temporary.name)
    for face, widths in _FACES.items():
        path = _DATA / "ttf" / f"DejaVuSans{face}.ttf"
        if font == "wide":
            copyfile(path, folder / path.name)
        else:
            _narrow(path, AFM(str(_DATA / "afm" / f"{widths}.afm"))).save(folder / f"DuetNarrow{face}.ttf")
        mono = _DATA / "ttf" / f"DejaVuSansMono{face}.ttf"
        copyfile(mono, folder / mono.name)
    families = dict.fromkeys(_SANS, _FAMILY[font]) | dict.fromkeys(_MONO, "DejaVu Sans Mono")
    aliases = "\n  ".join(_ALIAS.format(name=name, family=family) for name, family in families.items())
    file = folder / "fonts.conf"
    file.write_text(
        _CONFIG.format(folder=escape(str(folder)), family=_FAMILY[font], aliases=aliases), encoding="utf-8"
    )
    return file


def _narrow(path: Path, widths: AFM) -> TTFont:
    """Font at `path` with the advance widths and line height of Arial."""
    # Unchanged glyphs need not be read.
    font = TTFont(path, recalcBBoxes=False)
    names, glyphs, advances = font.getBestCmap(), font.getGlyphSet(), font["hmtx"]
    em = font["head"].unitsPerEm
    wanted = {toUnicode(name): widths[name][1] / 1000.0 * em for name in widths.chars()}
    # Letters without a width in Helvetica, such as Greek, are narrowed like the small letters.
    usual = sum(wanted[c] for c in "etaoinsr") / sum(advances[names[ord(c)]][0] for c in "etaoinsr")
    squeezed = {}
    for code in filter(names.__contains__, _LETTERS):
        name = names[code]
        old = advances[name][0]
        new = round(wanted.get(chr(code), usual * old))
        drawn, pen = DecomposingRecordingPen(glyphs), TTGlyphPen(None)
        glyphs[name].draw(drawn)
        drawn.replay(TransformPen(pen, (new / old if old else 1.0, 0.0, 0.0, 1.0, 0.0, 0.0)))
        squeezed[name] = pen.glyph(), new
    for name, (glyph, new) in squeezed.items():
        glyph.recalcBounds(font["glyf"])
        font["glyf"][name] = glyph
        advances[name] = new, getattr(glyph, "xMin", 0)
    for table in _OF_DESIGN:
        if table in font:
            del font[table]
    # Line height of Arial and Liberation Sans.
    font["hhea"].ascent, font["hhea"].descent, font["hhea"].lineGap = 1854, -434, 67
    font["OS/2"].usWinAscent, font["OS/2"].usWinDescent = 1854, 434
    for record in font["name"].names:
        if "DejaVu" in record.toUnicode():
            record.string = (
                record.toUnicode().replace("DejaVu Sans", "Duet Narrow").replace("DejaVuSans", "DuetNarrow")
            )
    return font
