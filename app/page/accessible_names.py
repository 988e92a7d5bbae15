"""Names of controls for those who listen to a page instead of looking at it: what stands beside a control is told with it."""

from typing import Final

ICONS: Final = {
    "search": "every command by name",
    "list": "every command by name",
    "adjustments": "connection and camera",
    "arrow": "back to the controls",
}
"""viser's own buttons that show nothing but an icon: a part of the icon's name, and the button's, said by `app.i18n.client_texts`."""


def names_script() -> str:
    """Return JavaScript that names every box and slider after the label of its row, and every group of buttons too."""
    return (
        "(()=>{const icons=" + repr(ICONS) + ";"
        "const row=e=>{for(let p=e.parentElement,i=0;p&&i<8;p=p.parentElement,i++){"
        "const l=p.querySelector('label');if(l)return l.textContent.trim();}return'';};"
        "const name=(e,text)=>{if(text&&e.getAttribute('aria-label')!==text)e.setAttribute('aria-label',text);};"
        "const go=()=>{"
        "for(const e of document.querySelectorAll('input:not([type=hidden]),textarea,[role=slider]'))"
        # A tick box has its label, and a box that was named by somebody else keeps that.
        "if(e.dataset.named||!e.getAttribute('aria-label')&&!(e.labels&&e.labels.length)){e.dataset.named='1';name(e,row(e));}"
        "for(const e of document.querySelectorAll('button'))if(!e.textContent.trim()&&(e.dataset.named||!e.getAttribute('aria-label'))){"
        "const svg=e.querySelector('svg'),of=svg?svg.getAttribute('class')||'':'';"
        "const found=Object.keys(icons).find(k=>of.includes(k));"
        "e.dataset.named='1';name(e,e.title||"
        "duetWord(found?icons[found]:e.closest('[class*=Notification-root]')?'dismiss this message':'more'));}};"
        "addEventListener('DOMContentLoaded',()=>{let asked=false;"
        "new MutationObserver(()=>{if(!asked){asked=true;setTimeout(()=>{asked=false;go();},150);}})"
        ".observe(document.body,{childList:true,subtree:true,characterData:true});go();});})();"
    )
