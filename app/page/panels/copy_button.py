"""A button that copies a text of the page: to the clipboard where the page may, by marking it where it may not (plain http)."""

import html
import json

from app.i18n.speaking import tr

WHILE: int = 2500
"""How long the button says that it is done [ms]."""


def copy_button(label: str, what: str) -> str:
    """Return a button as HTML that copies what stands beside it.

    Args:
        label: on the button.
        what: "pre" or "input": the kind of the element beside it that holds the text; it stays marked, so that it can be copied by hand.
    """
    done = json.dumps(tr("Copied"), ensure_ascii=False)
    script = (
        f"const b=this,p=b.parentElement.querySelector('{what}'),was=b.dataset.label,"
        f"say=()=>{{b.textContent={done};setTimeout(()=>{{b.textContent=was}},{WHILE})}},"
        "mark=()=>{p.select?p.select():getSelection().selectAllChildren(p)};mark();"
        "(navigator.clipboard?navigator.clipboard.writeText(p.value??p.textContent):Promise.reject()).then(say,"
        "()=>{mark();if(document.execCommand('copy'))say()})"
    )
    return (
        f'<button type="button" class="duet-copy" aria-live="polite" data-label="{html.escape(label)}" '
        f'onclick="{html.escape(script)}">{html.escape(label)}</button>'
    )
