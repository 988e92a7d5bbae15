"""Random mouse and keyboard actions on a page; every method returns a description of its action."""

from __future__ import annotations

import random
from typing import Final, Literal
from urllib.parse import quote

from playwright.sync_api import Page

SCRIPT: Final = "<img src=x onerror=alert(1)>"
KEYS: Final = (
    *" .[]RAVLG12345NBCHYX?",
    "ArrowLeft",
    "ArrowRight",
    "ArrowUp",
    "ArrowDown",
    "PageUp",
    "Escape",
    "Tab",
    "Enter",
)
TEXTS: Final = ("", SCRIPT, "\u202e", "é" * 300, "0", "-1", "1e999", "NaN", "0.12", "99999999", "12,5")
SIZES: Final = ((1440, 900), (1024, 768), (800, 600), (390, 844))
LINKS: Final = (
    *(
        "",
        "a" * 3000,
        f"q={quote(SCRIPT)}",
        "lesson=1",
        "lesson=3&step=2",
        "lesson=10",
        "lesson=99",
        "lesson=%3Cb%3E&step=-1",
    ),
    *(
        "step=2",
        "scene=imitation&ghost=frozen",
        "scene=nowhere",
        "rig=table&law=unprotected&dm=0.1&n=10",
        "dm=NaN&n=1e999&v=",
    ),
    *(
        "%00%ff=%fe",
        "dm=0.1&dm=0.2",
        "lang=de",
        "lang=xx",
        "robot=panda&scene=solo",
        "resume=../../etc",
        "window=0x0",
    ),
    "whatif=1&plot=speeds",
)
RUBBISH: Final = (
    ("empty.duet", b""),
    ("noise.duet", bytes(random.Random(0).randbytes(3000))),
    ("noise.bvh", b"HIERARCHY\nROOT Hips\n{\n OFFSET 0 0 nan\n"),
    ("half.zst", b"\x28\xb5\x2f\xfd" + bytes(range(50))),
    ("a.csv", b"t,x,y,z\n0,1e308,nan,x\n"),
    ("\N{PILE OF POO}.json", b'{"version": 1e999, "inputs": [[]]}' * 50),
)
_ELEMENTS: Final = """kind => [...document.querySelectorAll(kind)].filter(n => {
    const box = n.getBoundingClientRect();
    return box.width > 2 && box.height > 2 && box.bottom > 0 && box.right > 0 && box.top < innerHeight && box.left < innerWidth
        && !n.disabled && getComputedStyle(n).visibility !== 'hidden';
}).map(n => { const box = n.getBoundingClientRect();
    return [box.left + box.width / 2, box.top + box.height / 2,
        (n.innerText || n.getAttribute('aria-label') || n.tagName).slice(0, 40)]; })"""

_HANDLES: Final = """() => { const { camera, nodeRefFromName, canvas } = __viserMutable, box = canvas.getBoundingClientRect();
    return Object.entries(nodeRefFromName).filter(([name, node]) => node && /^.(gizmo|arms)/.test(name)).map(([name, node]) => {
        node.updateWorldMatrix(true, false); const v = node.getWorldPosition(node.position.clone()); v.project(camera);
        return [name, box.left + (1 + v.x) / 2 * box.width, box.top + (1 - v.y) / 2 * box.height]; }); }"""


class NothingThere(Exception):
    """The page has no element of the wanted kind."""


class Hands:
    def __init__(self, page: Page, choices: random.Random) -> None:
        self._page, self._mouse, self._keys, self._random = page, page.mouse, page.keyboard, choices

    def _pick(self, kind: str) -> tuple[float, float, str]:
        # One random number per choice, so that later choices do not depend on the number of elements here.
        found, place = self._page.evaluate(_ELEMENTS, kind), self._random.random()
        if not found:
            raise NothingThere(f"finds nothing like {kind}")
        return tuple(found[int(place * len(found))])

    def _pull(
        self, x: float, y: float, right: int, down: int, steps: int, button: Literal["left", "right"] = "left"
    ) -> str:
        self._mouse.move(x, y)
        self._mouse.down(button=button)
        for step in range(1, steps + 1):
            self._mouse.move(x + right * step / steps, y + down * step / steps)
        # Sometimes a key is pressed during a drag.
        key = self._random.choice("R12345XN") if self._random.random() < 0.15 else ""
        if key:
            self._keys.press(key)
        self._mouse.up(button=button)
        return f"from {x:.0f}, {y:.0f} by {right}, {down} px, pressing {key or 'nothing'} meanwhile"

    def click(self, kind: str) -> str:
        x, y, label = self._pick(kind)
        self._mouse.click(x, y, click_count=2 if self._random.random() < 0.05 else 1)
        return f"clicks on {label!r} at {x:.0f}, {y:.0f}"

    def choose(self) -> str:
        x, y, label = self._pick("input[role=combobox], input[aria-haspopup=listbox], [role=combobox]")
        self._mouse.click(x, y)
        return f"of the list {label!r} {self.click('[role=option]')}"

    def slide(self) -> str:
        x, y, label = self._pick("[role=slider]")
        if self._random.random() >= 0.4:
            return f"pulls the slider {label!r} {self._pull(x, y, self._random.randint(-160, 160), 0, 5)}"
        self._mouse.click(x, y)
        keys = self._random.choices(("ArrowLeft", "ArrowRight", "Home", "End"), k=self._random.randint(1, 5))
        for key in keys:
            self._keys.press(key)
        return f"presses {keys} on the slider {label!r}"

    def write(self) -> str:
        x, y, _ = self._pick("input[type=text]:not([role=combobox]), textarea, input[type=number]")
        text = self._random.choice(TEXTS)
        self._mouse.click(x, y, click_count=3)
        self._keys.insert_text(text) if text else self._keys.press("Delete")
        self._keys.press(self._random.choice(("Enter", "Tab", "Escape")))
        return f"types {text[:30]!r} at {x:.0f}, {y:.0f}"

    def press(self) -> str:
        keys = self._random.choices(KEYS, k=self._random.choice((1, 1, 1, 4)))
        if self._random.random() < 0.5:
            self._page.evaluate("document.activeElement?.blur()")
        for key in keys:
            self._keys.press(key)
        return f"presses {keys}"

    def drag_handle(self) -> str:
        handles = self._page.evaluate(_HANDLES)
        gizmos = [one for one in handles if one[0].startswith("/gizmo")] or handles
        if not gizmos:
            raise NothingThere("finds nothing to pull")
        name, x, y = gizmos[int(self._random.random() * len(gizmos))]
        right, down, *off = (self._random.randint(-most, most) for most in (250, 200, 40, 40))
        return f"pulls near {name} {self._pull(x + off[0], y + off[1], right, down, 8)}"

    def turn_view(self) -> str:
        x, y = self._random.randint(50, 700), self._random.randint(80, 500)
        if self._random.random() < 0.3:
            self._mouse.move(x, y)
            turn = self._random.choice((-900, 900, 200))
            self._mouse.wheel(0, turn)
            return f"turns the wheel by {turn} at {x}, {y}"
        button = self._random.choice(("left", "right"))
        right, down = self._random.randint(-250, 250), self._random.randint(-200, 200)
        return f"drags the view with the {button} button {self._pull(x, y, right, down, 8, button)}"

    def click_anywhere(self) -> str:
        size = self._page.viewport_size or {"width": 800, "height": 600}
        x, y = self._random.randint(0, size["width"] - 1), self._random.randint(48, size["height"] - 1)
        self._mouse.click(x, y, button=self._random.choice(("left", "left", "right")))
        return f"clicks anywhere at {x}, {y}"

    def give_file(self) -> str:
        """Open a file input; the listener chooses the file."""
        chosen = self._page.evaluate(
            """place => { const all = [...document.querySelectorAll('input[type=file]')]; if (!all.length) return false;
                all[Math.floor(place * all.length)].click(); return true; }""",
            self._random.random(),
        )
        return "opens a place for files" if chosen else "finds no place for files"

    def resize(self) -> str:
        width, height = self._random.choice(SIZES)
        self._page.set_viewport_size({"width": width, "height": height})
        return f"makes the window {width} × {height}"
