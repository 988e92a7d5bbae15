"""What the page does otherwise where the browser draws without a graphics card, as JavaScript that runs before viser's own."""

import json
from typing import Final

from app.i18n.client_texts import SOFTWARE
from app.page import STATIC

NOTE_MS: Final = 6000
"""So long the page says how the browser draws [ms]."""

TAIL_MS: Final = 400
"""So long after the last change the page draws on for a moment: what a browser prepares beside its frames is seen then [ms]."""


def software_script() -> str:
    """Return a script that finds out how the browser draws and, without a graphics card, says so and asks for less.

    The fast picture is chosen unless the link chose the fine one. Smoothed edges are left out of it: they cost a third of a
    picture's time. And a picture is drawn for a change alone: viser draws on for a quarter of a second after each, and
    where a picture takes 20 ms, the next change then waits behind pictures in which nothing is new.
    """
    return _without_card(
        _NOTE
        + "duetQuery.picture='fast';"
        + _DRAW_FOR_A_CHANGE
        + "if(new URLSearchParams(location.search).get('picture')==='fine')return;"
        "const get=HTMLCanvasElement.prototype.getContext;"
        "HTMLCanvasElement.prototype.getContext=function(kind,options){"
        "return get.call(this,kind,/^webgl/.test(kind)?{...options,antialias:false}:options);};"
    )


def software_note_script() -> str:
    """Return a script that says, without a graphics card, how the browser draws; once the window has the event `duet-built`."""
    return _without_card(_NOTE)


def _without_card(then: str) -> str:
    return (
        "(()=>{const gl=document.createElement('canvas').getContext('webgl');if(!gl)return;"
        "const info=gl.getExtension('WEBGL_debug_renderer_info');"
        "const name=info?gl.getParameter(info.UNMASKED_RENDERER_WEBGL):'';"
        "gl.getExtension('WEBGL_lose_context')?.loseContext();"
        "if(!/swiftshader|llvmpipe|softpipe|software|basic render/i.test(name))return;" + then + "})();"
    )


# viser asks the same, and puts a large notification over the scene until somebody closes it.
_NOTE: Final = (
    "for(const{prototype}of[WebGLRenderingContext,WebGL2RenderingContext]){const ask=prototype.getExtension;"
    "prototype.getExtension=function(name){return name==='WEBGL_debug_renderer_info'?null:ask.call(this,name)}}"
    "addEventListener('duet-built',()=>{const style=document.createElement('style'),note=document.createElement('div');"
    f"style.textContent={json.dumps((STATIC / 'software.css').read_text(encoding='utf-8'))};document.head.append(style);"
    "note.id='duet-note';note.setAttribute('role','status');document.body.append(note);"
    f"note.textContent=duetWord({json.dumps(SOFTWARE)});setTimeout(()=>note.remove(),{NOTE_MS})"
    "},{once:true});"
)

# viser counts its quarter of a second from `performance.now()`, and offers no other way to shorten it.
_DRAW_FOR_A_CHANGE: Final = (
    "let page,draw=()=>{},tail=0;"
    "const once=()=>{const now=performance.now;performance.now=()=>now.call(performance)-248;"
    "try{draw()}finally{delete performance.now}"
    f"clearTimeout(tail);tail=setTimeout(()=>draw(),{TAIL_MS})}};"
    "Object.defineProperty(window,'__viserMutable',{configurable:true,get:()=>page,set:found=>{"
    "page=found;draw=found.requestRender;"
    "Object.defineProperty(found,'requestRender',{configurable:true,enumerable:true,get:()=>once,set:own=>{draw=own}})}});"
)
