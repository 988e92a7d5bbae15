"""Search for untranslated texts."""

import re

NO_TEXT = re.compile(
    # Style and drawings; names, symbols and lesson files (pre, kbd, code); the remaining tags and entities.
    r"<style>.*?</style>|<svg.*?</svg>|<pre.*?</pre>|<kbd>.*?</kbd>|<code>.*?</code>|<[^>]*>|&\w+;",
    re.DOTALL,
)
NAMED = re.compile(r"""\b(?:aria-label|title|alt|placeholder)=(?:"([^"]*)")""")
"""Attributes that a screen reader reads."""
WORD = re.compile(r"(?<!d_)(?<!d_l)[^\W\d_]{3,}")
"""Words of a text; d_law is a symbol."""
NAMES = frozenset({"rad", "rad²", "mm²", "MediaPipe", "FILE", "dot", "min", "max", "sym", "Duet"})


def untranslated(text: str) -> list[str]:
    """Words of a text and of its attributes outside the brackets of the pseudo-language."""
    named = "\n".join(NAMED.findall(text))
    plain_text = NO_TEXT.sub("\n", f"{text}\n{named}")
    while "⟦" in plain_text:
        # Innermost brackets first: a sentence may have translated parts.
        shorter = re.sub(r"⟦[^⟦⟧]*⟧", "", plain_text)
        if shorter == plain_text:
            break
        plain_text = shorter
    return [word for word in WORD.findall(plain_text) if word not in NAMES]
