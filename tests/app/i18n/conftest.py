"""A look for what was never translated."""

import re

NO_TEXT = re.compile(
    # Style, drawings and code; then what is left of tags; what is a name or a symbol; what a lesson's own file says.
    r"<style>.*?</style>|<svg.*?</svg>|<pre.*?</pre>|<kbd>.*?</kbd>|<code>.*?</code>|<[^>]*>|&\w+;",
    re.DOTALL,
)
NAMED = re.compile(r"""\b(?:aria-label|title|alt|placeholder)=(?:"([^"]*)")""")
"""Attributes that a screen reader reads."""
WORD = re.compile(r"(?<!d_)(?<!d_l)[^\W\d_]{3,}")
"""Words of a text; d_law is a symbol."""
NAMES = frozenset({"rad", "rad²", "mm²", "MediaPipe", "FILE", "dot", "min", "max", "sym", "Duet"})


def untranslated(text: str) -> list[str]:
    """The words of a text, and of the names of its parts, that stand outside the brackets of the pseudo-language."""
    named = "\n".join(NAMED.findall(text))
    plain_text = NO_TEXT.sub("\n", f"{text}\n{named}")
    while "⟦" in plain_text:
        # The innermost first: a sentence may have translated parts.
        shorter = re.sub(r"⟦[^⟦⟧]*⟧", "", plain_text)
        if shorter == plain_text:
            break
        plain_text = shorter
    return [word for word in WORD.findall(plain_text) if word not in NAMES]
