"""A real browser with a real mouse, for tests.

No test sleeps: every wait is for a visible change of the page (an element, a pose, a number of drawn frames).
"""

import os
import re
import shutil
import socket
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import (
    Browser,
    ConsoleMessage,
    Error,
    Locator,
    Page,
    Playwright,
    sync_playwright,
)

from controllers.system_libraries import MissingLibrary, missing_library, remedy
from tests.fonts import Font, font_environment
from tests.system_packages import install_package, run, with_libraries

FAILED = pytest.StashKey[bool]()
FLAGS = (
    *(
        "--use-gl=angle",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
        "--no-sandbox",
        "--disable-quic",
        "--no-first-run",
    ),
    *(
        "--disable-background-networking",
        "--disable-component-update",
        "--disable-sync",
        "--disable-dev-shm-usage",
    ),
    # Without a graphics card, compositing without WebGL takes a tenth of the time.
    "--disable-gpu-compositing",
)
_NAMES = (
    "google-chrome",
    "google-chrome-stable",
    "chromium",
    "chromium-browser",
    "microsoft-edge",
    "chrome",
    "msedge",
)
_MAC = ("Google Chrome", "Chromium", "Microsoft Edge")
_WINDOWS = (
    r"Google\Chrome\Application\chrome.exe",
    r"Chromium\Application\chrome.exe",
    r"Microsoft\Edge\Application\msedge.exe",
)

# Messages about software rendering, and about servers that a test stops on purpose.
_HARMLESS = (
    *(
        r"GPU stall due to ReadPixels",
        r"WebGL-.*GL Driver Message",
        r"Automatic fallback to software WebGL",
        r"software WebGL",
    ),
    *(r"WebSocket connection to .* failed", r"net::ERR_CONNECTION_(REFUSED|RESET)", r"THREE\.THREE\.Clock"),
    r"THREE\.WebGLRenderer: (Context Lost|KHR_parallel_shader_compile)",
)


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def installed_browser() -> str | None:
    """Path of a browser of the Chromium family: `DUET_BROWSER`, or one installed at a usual place.

    Raises:
        FileNotFoundError: `DUET_BROWSER` does not exist.
    """
    wanted = os.environ.get("DUET_BROWSER")
    if wanted:
        path = shutil.which(wanted)
        if path is None:
            raise FileNotFoundError(
                f"DUET_BROWSER={wanted} does not exist; name the executable of Chrome, Chromium or Edge, or unset it"
            )
        return path
    folders = [Path("/Applications"), Path.home() / "Applications"] if sys.platform == "darwin" else []
    candidates = [Path(path) for path in map(shutil.which, _NAMES) if path]
    candidates += [folder / f"{name}.app/Contents/MacOS/{name}" for folder in folders for name in _MAC]
    if sys.platform == "win32":
        roots = (os.environ.get(name) for name in ("PROGRAMFILES", "PROGRAMFILES(X86)", "LOCALAPPDATA"))
        candidates += [Path(root) / name for root in roots if root for name in _WINDOWS]
    return next((str(path) for path in candidates if path.is_file()), None)


@contextmanager
def started_playwright() -> Iterator[Playwright]:
    """Playwright, with the system libraries of its driver.

    Raises:
        MissingLibrary: a library is missing and cannot be installed here.
    """
    with_libraries(_try_driver)
    with sync_playwright() as playwright:
        yield playwright


def _try_driver() -> None:
    said = run([sys.executable, "-m", "playwright", "--version"])
    if (library := missing_library(said)) is not None:
        raise MissingLibrary(remedy(library, "Playwright's driver"), library)


def launch(playwright: Playwright, font: Font = "wide") -> Browser:
    """Start a browser with one of our fonts; install a browser if the machine has none.

    Raises:
        RuntimeError: no browser is available; the message lists all attempts.
    """
    tried: list[str] = []

    def own() -> list[str]:
        return [run([sys.executable, "-m", "playwright", "install", "chromium"])]

    for install in (list[str], own, lambda: install_package("chromium")):
        tried += install()
        path = None if install is own else installed_browser()
        try:
            return playwright.chromium.launch(
                executable_path=path, headless=True, args=list(FLAGS), env={**font_environment(font)}
            )
        except Error as error:
            name = path or "Playwright’s own Chromium"
            library = missing_library(error.message)
            tried.append(remedy(library, name) if library else f"{name}: {error.message.splitlines()[0]}")
    raise RuntimeError(
        "no browser for the browser tests; install Chrome, Chromium or Edge, or name one in DUET_BROWSER.\nTried:\n  "
        + "\n  ".join(entry for entry in tried if entry)
    )


BrowserIn = Callable[[Font], Browser]


@pytest.fixture(scope="session")
def browser_in() -> Iterator[BrowserIn]:
    """`browser_in(font)`: the browser with that font, started at its first use."""
    started: dict[Font, Browser] = {}
    with ExitStack() as opened:
        try:
            playwright = opened.enter_context(started_playwright())
        except MissingLibrary as error:
            raise pytest.fail.Exception(str(error), pytrace=False) from None

        def get(font: Font) -> Browser:
            if font not in started:
                try:
                    started[font] = launch(playwright, font)
                except (RuntimeError, FileNotFoundError) as error:
                    raise pytest.fail.Exception(str(error), pytrace=False) from None
            return started[font]

        yield get
        for each in started.values():
            each.close()


@pytest.fixture(scope="session")
def browser(browser_in: BrowserIn) -> Browser:
    return browser_in("wide")


PageAt = Callable[..., Page]

UNSEEN = """window.duetUnseen = true;
for (const name of ["drawArrays", "drawElements", "drawArraysInstanced", "drawElementsInstanced", "clear"]) {
  const draw = window.WebGL2RenderingContext?.prototype[name];
  if (draw) WebGL2RenderingContext.prototype[name] = function (...given) { if (!window.duetUnseen) draw.apply(this, given); };
}"""
"""The scene is computed and laid out, and listens to input, but is only filled inside `drawn`: without a
graphics card filling is most of a frame's work.
"""


def listen(page: Page, complaints: list[str], *expect: str) -> Callable[[], None]:
    """Collect console errors and uncaught exceptions of a page, except those that match a regular expression.
    Returns a function that ends it.
    """
    forgiven = re.compile("|".join((*_HARMLESS, *expect)))

    def hear(kind: str, text: str) -> None:
        if not forgiven.search(text):
            complaints.append(f"{kind}: {text}")

    def on_console(message: ConsoleMessage) -> None:
        if message.type == "error":
            hear("console", f"{message.text} {message.location.get('url', '')}")

    def on_error(error: Error) -> None:
        hear("uncaught", str(error))

    def end() -> None:
        page.remove_listener("console", on_console)
        page.remove_listener("pageerror", on_error)

    page.on("console", on_console)
    page.on("pageerror", on_error)
    return end


def artefacts() -> Path:
    """Folder for pictures: `DUET_ARTIFACTS`, else `.artifacts` at the root of the repository."""
    folder = Path(os.environ.get("DUET_ARTIFACTS") or Path(__file__).parents[1] / ".artifacts")
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def close_software_note(page: Page) -> None:
    """Close viser's note about software rendering, which appears only without a graphics card."""
    page.evaluate(
        """() => { for (const note of document.querySelectorAll('[class*=Notification-root]'))
             if (/webgl/i.test(note.textContent)) note.querySelector('button')?.click(); }"""
    )


@contextmanager
def drawn(page: Page) -> Iterator[None]:
    """Fill the page's 3-D picture while open, starting with the present one."""
    page.evaluate("() => { window.duetUnseen = false; window.__viserMutable?.requestRender?.(); }")
    wait_frames(page, 3)
    yield
    page.evaluate("() => { window.duetUnseen = true; }")


def save_picture(page: Page, name: str) -> None:
    """Save a picture as `name`.png, without viser's note about software rendering."""
    close_software_note(page)
    page.wait_for_function(
        """() => ![...document.querySelectorAll('[class*=Notification-root]')]
             .some(note => /webgl/i.test(note.textContent))"""
    )
    with drawn(page):
        page.screenshot(path=artefacts() / f"{name}.png", animations="disabled")


def screenshot(page: Page, name: str) -> None:
    """Save a picture if `DUET_ARTIFACTS` is set; each takes two seconds."""
    if os.environ.get("DUET_ARTIFACTS"):
        save_picture(page, name)


def wait_frames(page: Page, count: int = 2) -> None:
    page.evaluate(
        "n => new Promise(done => { const step = () => (n-- > 0 ? requestAnimationFrame(step) : done()); step(); })",
        count,
    )


BETWEEN = 3
"""Drawn frames between two queries of a page: a query after every frame costs as much as the page itself."""


def until(page: Page, true: Callable[[], object], what: str = "it", seconds: float = 60.0) -> None:
    """Wait until `true()` is true, asked every few drawn frames."""
    deadline = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < deadline, f"{what}: not within {seconds:g} s"
        wait_frames(page, BETWEEN)


WELCOMED = "try { localStorage.duetWelcome ??= '1'; localStorage.duetPanel ??= 'all'; } catch {}"
"""Init script of a browser that hides the welcome and shows every setting."""


def lasting(page: Page, faults: Callable[[], list[str]]) -> list[str]:
    """Faults that remain until a time limit: a slow machine may still be building the page at first."""
    found: list[str] = []

    def none() -> bool:
        found[:] = faults()
        return not found

    with suppress(AssertionError):
        until(page, none, "a page without faults")
    return found


CAMERA = "[...__viserMutable.camera.position.toArray(), ...__viserMutable.camera.quaternion.toArray()]"


STILL = 1.5
"""A view that is constant for this time [s] has settled: the page reports its layout at such intervals."""


def _settled(page: Page, look: Callable[[], Any], frames: int, what: str) -> np.ndarray:
    seen: list[np.ndarray] = []
    since = time.monotonic()

    def still() -> bool:
        nonlocal since
        seen.append(np.array(look(), float))
        if len(seen) == 1 or not np.allclose(seen[-1], seen[-2], atol=1e-6):
            del seen[:-1]
            since = time.monotonic()
        return BETWEEN * len(seen) > frames and time.monotonic() - since > STILL

    until(page, still, what)
    return seen[-1]


def settled_view(page: Page, frames: int = 20) -> np.ndarray:
    """Camera after its adjustment to the page's layout, constant for at least `frames` drawn frames."""
    return _settled(page, lambda: page.evaluate(CAMERA), frames, "a view that stays")


def settled_box(page: Page, place: Locator) -> np.ndarray:
    """Left, top, width and height of an element [px], once the layout is at rest."""

    def look() -> list[float]:
        box = place.bounding_box()
        return [np.nan] * 4 if box is None else [box["x"], box["y"], box["width"], box["height"]]

    return _settled(page, look, 5, "a place that stays")


_CANVAS = "(__viserMutable.canvas.querySelector?.('canvas') ?? document.querySelector('canvas[data-engine]'))"


def wait_ready(page: Page, node: str) -> None:
    """Wait until the scene node `node` exists and the canvas is visible."""
    page.wait_for_function(
        f"name => window.__viserMutable?.nodeRefFromName?.[name] && +{_CANVAS}?.style.opacity === 1"
        " && (document.documentElement.matches('.duet-built') || !document.getElementById('duet-loading'))",
        arg=node,
        timeout=60_000,
    )
    wait_frames(page)


def world_position(page: Page, node: str) -> np.ndarray:
    """Drawn position of a node's origin, in the scene's coordinates (z up).

    Not for a gizmo under the mouse: until the server moves it, its node stays at the start of the drag.
    """
    return np.array(
        page.evaluate(
            """name => { const all = __viserMutable.nodeRefFromName, node = all[name], point = node.position.clone();
                 node.updateWorldMatrix(true, false); node.getWorldPosition(point); all[""].worldToLocal(point);
                 return point.toArray(); }""",
            node,
        )
    )


def world_to_px(page: Page, point: Sequence[float] | np.ndarray) -> tuple[float, float]:
    x, y = page.evaluate(
        """p => { const { camera, nodeRefFromName, canvas } = __viserMutable, box = canvas.getBoundingClientRect();
             const v = camera.position.clone().set(...p); nodeRefFromName[""].localToWorld(v); v.project(camera);
             return [box.left + (1 + v.x) / 2 * box.width, box.top + (1 - v.y) / 2 * box.height]; }""",
        [float(value) for value in point],
    )
    return float(x), float(y)


def point_at(page: Page, point: Sequence[float] | np.ndarray) -> None:
    """Move the mouse to an uncovered point of the scene, and wait until the page has noticed it."""
    x, y = world_to_px(page, point)
    on_top = page.evaluate("([x, y]) => document.elementFromPoint(x, y) === __viserMutable.canvas", [x, y])
    assert on_top, f"something covers the scene at ({x:.0f}, {y:.0f}) px"
    page.mouse.move(x, y)
    wait_frames(page, 3)


def take_hold(page: Page, point: Callable[[], np.ndarray], held: Callable[[], object]) -> None:
    """Press the mouse on a handle; again if the view or the handle still moved.

    Args:
        page: a tab wider than 576 px.
        point: grip in the scene, asked before every attempt.
        held: True while it is dragged; AssertionError after five failed attempts.
    """
    for attempt in range(1, 6):
        settled_view(page, 5)
        x, y = world_to_px(page, point())
        # A handle finds the pointer by its motion, which must come before the button.
        page.mouse.move(x - 3, y - 3)
        wait_frames(page)
        try:
            point_at(page, point())
            page.mouse.down()
            until(page, held, "taking hold", 20.0)
            return
        except AssertionError:
            page.mouse.up()
            if attempt == 5:
                raise
