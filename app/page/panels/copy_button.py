"""A button that copies a text of the page; the script `copy_button.js` listens to it."""

import html

from app.i18n.speaking import tr


def copy_button(label: str, what: str) -> str:
    """Return a button as HTML that copies the text beside it.

    Args:
        label: on the button.
        what: "pre" or "input": the kind of the element beside it that holds the text.
    """
    shown = html.escape(label)
    return (
        f'<button type="button" class="duet-copy" aria-live="polite" data-copies="{what}" data-label="{shown}" '
        f'data-done="{html.escape(tr("Copied"))}">{shown}</button>'
    )
