"""The teacher's key on the page: it is kept by the tab and not shown, and a wrong one is named."""

from typing import Final

import viser

from app.i18n.speaking import N_, tr

WRONG_KEY: Final = N_(
    "This is not the teacher's key: you are here as a student. Whoever started Duet knows the link with the right one."
)
WRONG_TITLE: Final = N_("The key is another one")


def name_mistake(client: viser.ClientHandle) -> None:
    """Say on a page that its key is another one, and have its tab forget it."""
    client.gui.add_html('<i class="duet-key-wrong"></i>', order=1000.0)
    client.add_notification(tr(WRONG_TITLE), tr(WRONG_KEY), color="orange", auto_close_seconds=12.0)


def key_script() -> str:
    """Return JavaScript that takes the key out of the address bar, where a projector shows it and every copied link has it.

    The tab keeps it for when the page is loaded again, until the page says that it is a wrong one. Where the browser keeps no
    data of the page, the address is the only place for it.
    """
    return (
        "(()=>{try{const url=new URL(location.href),given=url.searchParams.get('key');"
        "if(given!==null){sessionStorage.setItem('duetKey',given);url.searchParams.delete('key');"
        "history.replaceState(history.state,'',url);}"
        "const known=sessionStorage.getItem('duetKey');if(!known)return;duetQuery.key=known;"
        "const look=setInterval(()=>{if(document.querySelector('.duet-key-wrong')){"
        "sessionStorage.removeItem('duetKey');clearInterval(look);}},300);}catch{}})();"
    )
