"""What every page runs for the class: its style sheet, and a place above everything for what the teacher shows to all."""

import json

from app.page import STATIC


def class_script() -> str:
    """Return JavaScript that puts the style sheet into the page and shows what `.duet-overlay` holds over the whole of it.

    Inside a panel it could not cover more than the panel. Whoever has read it may close it for themselves, by the button or Esc.
    """
    css = json.dumps((STATIC / "teacher.css").read_text(encoding="utf-8")).replace("<", "\\u003c")
    return (
        "addEventListener('DOMContentLoaded',()=>{"
        f"const style=document.createElement('style');style.textContent={css};document.head.append(style);"
        "const over=document.createElement('div');over.id='duet-overlay';over.setAttribute('role','dialog');"
        "over.setAttribute('aria-label','From the teacher');document.body.append(over);"
        "let shown='';const close=()=>{over.textContent='';};"
        "over.addEventListener('click',e=>{if(e.target===over||e.target.closest('button'))close();});"
        "addEventListener('keydown',e=>{if(e.key==='Escape'&&over.firstChild)close();});"
        "setInterval(()=>{const now=document.querySelector('.duet-overlay')?.innerHTML??'';"
        "if(now!==shown){shown=now;over.innerHTML=now;}},250);});"
    )
