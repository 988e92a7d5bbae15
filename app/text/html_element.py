"""HTML elements with escaped text and attributes."""

import html


def element(tag: str, text: str = "", *children: str, **attributes: str) -> str:
    """Return an HTML element.

    Args:
        tag: its name.
        text: at its beginning; escaped.
        children: after the text; HTML.
        attributes: by name, escaped; an underscore at the end is dropped (`class_`), any other becomes a hyphen.
    """
    given = "".join(f' {name.rstrip("_").replace("_", "-")}="{html.escape(value)}"' for name, value in attributes.items())
    return f"<{tag}{given}>{html.escape(text, quote=False)}{''.join(children)}</{tag}>"
