"""All that can be done on a page with a mouse and a keyboard, at random; every method says what it did."""

from __future__ import annotations

import random
from typing import Final

from playwright.sync_api import Page

from tests.tools.monkey.material import KEYS, SIZES, TEXTS

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


class Hands:
    """Mouse and keyboard of one visitor.

    Args:
        page: that they act on.
        choices: of what they do.
    """

    def __init__(self, page: Page, choices: random.Random) -> None:
        self._page, self._random = page, choices

    def _pick(self, kind: str) -> tuple[float, float, str] | None:
        found = self._page.evaluate(_ELEMENTS, kind)
        # A number between 0 and 1 picks the same one of as many, however many were picked from before.
        place = self._random.random()
        return tuple(found[int(place * len(found))]) if found else None

    def click(self, kind: str) -> str:
        """Click on one of the elements of a kind."""
        found = self._pick(kind)
        if found is None:
            return f"finds nothing like {kind}"
        x, y, label = found
        self._page.mouse.click(x, y, click_count=2 if self._random.random() < 0.05 else 1)
        return f"clicks on {label!r} at {x:.0f}, {y:.0f}"

    def choose(self) -> str:
        """Open a list and choose an option."""
        found = self._pick("input[role=combobox], input[aria-haspopup=listbox], [role=combobox]")
        if found is None:
            return "finds no list"
        self._page.mouse.click(found[0], found[1])
        option = self._pick("[role=option]")
        if option is None:
            return f"opens a list at {found[0]:.0f}, {found[1]:.0f}"
        self._page.mouse.click(option[0], option[1])
        return f"chooses {option[2]!r} of a list at {found[0]:.0f}, {found[1]:.0f}"

    def slide(self) -> str:
        """Move a slider by keys or by the mouse."""
        found = self._pick("[role=slider]")
        if found is None:
            return "finds no slider"
        x, y, label = found
        if self._random.random() < 0.4:
            self._page.mouse.click(x, y)
            keys = [self._random.choice(("ArrowLeft", "ArrowRight", "Home", "End")) for _ in range(self._random.randint(1, 5))]
            for key in keys:
                self._page.keyboard.press(key)
            return f"presses {keys} on the slider {label!r}"
        way = self._random.randint(-160, 160)
        self._page.mouse.move(x, y)
        self._page.mouse.down()
        for step in range(1, 6):
            self._page.mouse.move(x + way * step / 5, y)
        self._page.mouse.up()
        return f"drags the slider {label!r} by {way} px"

    def write(self) -> str:
        """Type a text into a field."""
        found = self._pick("input[type=text]:not([role=combobox]), textarea, input[type=number]")
        text = self._random.choice(TEXTS)
        if found is None:
            return "finds no field"
        self._page.mouse.click(found[0], found[1], click_count=3)
        self._page.keyboard.insert_text(text) if text else self._page.keyboard.press("Delete")
        self._page.keyboard.press(self._random.choice(("Enter", "Tab", "Escape")))
        return f"types {text[:30]!r} at {found[0]:.0f}, {found[1]:.0f}"

    def press(self) -> str:
        """Press a key or four, half of the time outside of any field."""
        keys = [self._random.choice(KEYS) for _ in range(self._random.choice((1, 1, 1, 4)))]
        if self._random.random() < 0.5:
            self._page.evaluate("document.activeElement?.blur()")
        for key in keys:
            self._page.keyboard.press(key)
        return f"presses {keys}"

    def _drag(self, x: float, y: float, button: str = "left") -> str:
        right, down = self._random.randint(-250, 250), self._random.randint(-200, 200)
        mouse = self._page.mouse
        mouse.move(x, y)
        mouse.down(button=button)  # pyright: ignore[reportArgumentType]
        for step in range(1, 9):
            mouse.move(x + right * step / 8, y + down * step / 8)
        # Now and then something else happens in mid-drag.
        if self._random.random() < 0.15:
            key = self._random.choice("R12345XN")
            self._page.keyboard.press(key)
            right_key = f", pressing {key} meanwhile"
        else:
            right_key = ""
        mouse.up(button=button)  # pyright: ignore[reportArgumentType]
        return f"by {right}, {down} px{right_key}"

    def drag_handle(self) -> str:
        """Pull near a handle."""
        handles = self._page.evaluate(_HANDLES)
        gizmos = [one for one in handles if one[0].startswith("/gizmo")] or handles
        if not gizmos:
            return "finds nothing to pull"
        name, x, y = gizmos[int(self._random.random() * len(gizmos))]
        x, y = x + self._random.randint(-40, 40), y + self._random.randint(-40, 40)
        return f"pulls near {name} from {x:.0f}, {y:.0f} {self._drag(x, y)}"

    def turn_view(self) -> str:
        """Drag the view, or turn the wheel."""
        x, y = self._random.randint(50, 700), self._random.randint(80, 500)
        if self._random.random() < 0.3:
            self._page.mouse.move(x, y)
            turn = self._random.choice((-900, 900, 200))
            self._page.mouse.wheel(0, turn)
            return f"turns the wheel by {turn} at {x}, {y}"
        button = self._random.choice(("left", "right"))
        return f"drags the view with the {button} button from {x}, {y} {self._drag(x, y, button)}"

    def click_anywhere(self) -> str:
        """Click on any place of the window below its top."""
        size = self._page.viewport_size or {"width": 800, "height": 600}
        x, y = self._random.randint(0, size["width"] - 1), self._random.randint(48, size["height"] - 1)
        self._page.mouse.click(x, y, button=self._random.choice(("left", "left", "right")))
        return f"clicks anywhere at {x}, {y}"

    def give_file(self) -> str:
        """Ask for a file by a place for files; who listens gives it."""
        chosen = self._page.evaluate(
            """place => { const all = [...document.querySelectorAll('input[type=file]')]; if (!all.length) return false;
                all[Math.floor(place * all.length)].click(); return true; }""",
            self._random.random(),
        )
        return "opens a place for files" if chosen else "finds no place for files"

    def resize(self) -> str:
        """Make the window larger or smaller."""
        width, height = self._random.choice(SIZES)
        self._page.set_viewport_size({"width": width, "height": height})
        return f"makes the window {width} × {height}"
