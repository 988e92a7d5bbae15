"""What the page does otherwise where the browser draws without a graphics card, as JavaScript that runs before viser's own."""

from typing import Final

TAIL_MS: Final = 400
"""So long after the last change the page draws on for a moment: what a browser prepares beside its frames is seen then [ms]."""


def software_script() -> str:
    """Return a script that finds out how the browser draws and, without a graphics card, asks for less.

    The fast picture is chosen unless the link chose the fine one. Smoothed edges are left out of it: they cost a third of a
    picture's time. And a picture is drawn for a change alone: viser draws on for a quarter of a second after each, and
    where a picture takes 20 ms, the next change then waits behind pictures in which nothing is new.
    """
    return (
        "(()=>{const gl=document.createElement('canvas').getContext('webgl');if(!gl)return;"
        "const info=gl.getExtension('WEBGL_debug_renderer_info');"
        "const name=info?gl.getParameter(info.UNMASKED_RENDERER_WEBGL):'';"
        "gl.getExtension('WEBGL_lose_context')?.loseContext();"
        "if(!/swiftshader|llvmpipe|softpipe|software|basic render/i.test(name))return;"
        "duetQuery.picture='fast';"
        + _DRAW_FOR_A_CHANGE
        + "if(new URLSearchParams(location.search).get('picture')==='fine')return;"
        "const get=HTMLCanvasElement.prototype.getContext;"
        "HTMLCanvasElement.prototype.getContext=function(kind,options){"
        "return get.call(this,kind,/^webgl/.test(kind)?{...options,antialias:false}:options);};})();"
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
