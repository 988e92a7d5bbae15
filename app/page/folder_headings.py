"""Folders of controls for keyboards and screen readers: viser draws a folder's heading as a box that only a mouse can open."""


def folder_script() -> str:
    """Return JavaScript that makes the heading of every folder a button: with a role, a state, and the keys Enter and Space."""
    return (
        "(()=>{const heading='.mantine-Paper-root>.mantine-Paper-root';"
        "const mend=()=>{for(const icon of document.querySelectorAll(heading+'>svg[class*=tabler-icon-chevron]')){"
        "const button=icon.parentElement,open=String(icon.matches('.tabler-icon-chevron-up'));"
        "if(button.ariaExpanded===open)continue;"
        "button.setAttribute('role','button');button.tabIndex=0;button.ariaExpanded=open;icon.ariaHidden='true'}};"
        "addEventListener('DOMContentLoaded',()=>new MutationObserver(mend).observe(document.body,{childList:true,subtree:true}));"
        "addEventListener('keydown',e=>{if(e.key!=='Enter'&&e.key!==' '||!e.target.matches?.(heading+'[role=button]'))return;"
        "e.preventDefault();e.stopImmediatePropagation();if(!e.repeat)e.target.click()},true)})();"
    )
