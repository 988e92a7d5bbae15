"""A real browser with a real mouse, for tests.

No test sleeps: every wait is for something that can be seen in the page (an element, a pose, a number of drawn frames).
"""

import asyncio
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
    BrowserContext,
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
    # Without a graphics card, the page around the scene costs a tenth of the time if it is put together without WebGL's machinery.
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

# Said by the browser and by three.js about software rendering, and about servers that a test stops on purpose.
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
    """The path of a browser of the Chromium family: `DUET_BROWSER`, or one installed at a usual place.

    Raises:
        FileNotFoundError: `DUET_BROWSER` names nothing that exists.
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
    """Playwright, with the system's libraries that its driver needs.

    Raises:
        MissingLibrary: one of them is missing and cannot be installed here.
    """
    with_libraries(_try_driver)
    with sync_playwright() as playwright:
        yield playwright


def _try_driver() -> None:
    said = run([sys.executable, "-m", "playwright", "--version"])
    if (library := missing_library(said)) is not None:
        raise MissingLibrary(remedy(library, "Playwright's driver"), library)


def launch(playwright: Playwright, font: Font = "wide") -> Browser:
    """Start a browser that draws text in a font of ours; install a browser if the machine has none.

    Raises:
        RuntimeError: none can be had; the message lists all that was tried.
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
    """`browser_in(font)` is the browser with that font, started when it is first asked for."""
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

_UNSEEN = """window.duetUnseen = true;
for (const name of ["drawArrays", "drawElements", "drawArraysInstanced", "drawElementsInstanced", "clear"]) {
  const draw = window.WebGL2RenderingContext?.prototype[name];
  if (draw) WebGL2RenderingContext.prototype[name] = function (...given) { if (!window.duetUnseen) draw.apply(this, given); };
}"""
"""The scene is computed, laid out and listens as always, but nothing is filled until that is asked for by `drawn`: without a graphics card
it is most of the work of a frame."""


def listen(page: Page, complaints: list[str], *expect: str) -> Callable[[], None]:
    """Note every console error and uncaught exception of a page, but for what matches one of the regular expressions.

    Returns what ends it.
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


@pytest.fixture(scope="session")
def used_tabs() -> list[Page]:
    """Tabs for the next test: one that has shown the page before shows it again in half of the time."""
    return []


def _emptied(page: Page) -> bool:
    """Forget all that a page has left in its tab, and return whether it is as good as new."""
    if page.is_closed() or len(page.context.pages) > 1:
        return False
    try:
        if page.url.startswith("http"):
            page.evaluate("() => { sessionStorage.clear(); localStorage.clear(); }")
        page.goto("about:blank")
        page.context.clear_cookies()
        page.mouse.up()
        page.mouse.move(0, 0)
    except Error:
        return False
    return True


def _close(context: BrowserContext) -> None:
    """Close a tab with all that is its own; one that does not answer goes with the browser, and holds no test up until then."""
    with suppress(TimeoutError, Error):
        context._sync(asyncio.wait_for(context._impl_obj.close(reason=None), 30.0))


@pytest.fixture
def page_at(
    browser: Browser, browser_in: BrowserIn, used_tabs: list[Page], request: pytest.FixtureRequest
) -> Iterator[PageAt]:
    """`page_at(width, height, expect=(…), font=…)` opens an empty tab of that size, with wide letters unless they are to be narrow.

    A console error or an uncaught exception in the page fails the test, unless it matches one of the regular expressions in
    `expect`. A newcomer sees the welcome, as once in a browser; others have seen it. A tab that has been used before has nothing left
    of it; a test that gives its tab scripts, routes, listeners or a protocol session asks for a `fresh` one. A failed test leaves a
    picture of every tab in the artefact folder.
    """
    complaints: list[str] = []
    pages: list[tuple[Page, bool]] = []
    deaf: list[Callable[[], None]] = []

    def open_page(
        width: int = 800,
        height: int = 600,
        *,
        expect: Sequence[str] = (),
        newcomer: bool = False,
        fresh: bool = False,
        font: Font = "wide",
        **options: Any,
    ) -> Page:
        fresh = fresh or newcomer or bool(options) or font != "wide"
        if used_tabs and not fresh:
            page = used_tabs.pop()
            page.set_viewport_size({"width": width, "height": height})
        else:
            context = browser_in(font).new_context(viewport={"width": width, "height": height}, **options)
            context.add_init_script(_UNSEEN)
            if not newcomer:
                context.add_init_script(WELCOMED)
            page = context.new_page()
        page.context.set_default_timeout(60_000)
        deaf.append(listen(page, complaints, *expect))
        pages.append((page, fresh))
        return page

    yield open_page
    failed = request.node.stash.get(FAILED, False)
    if complaints or failed:
        for index, (page, _) in enumerate(pages):
            name = re.sub(r"[^\w.-]+", "_", request.node.nodeid)[-120:]
            try:
                save_picture(page, f"{name}-{index}")
            except Error as error:
                print(f"no picture of tab {index}: {error.message}")
    for (page, fresh), end in zip(pages, deaf, strict=True):
        if not (fresh or failed or complaints) and _emptied(page):
            end()
            used_tabs.append(page)
        else:
            _close(page.context)
    assert not complaints, "the page complained:\n" + "\n".join(complaints)


def artefacts() -> Path:
    """Where pictures go: `DUET_ARTIFACTS`, else `.artifacts` at the root of the repository."""
    folder = Path(os.environ.get("DUET_ARTIFACTS") or Path(__file__).parents[1] / ".artifacts")
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def close_software_note(page: Page) -> None:
    """Close viser's note about software rendering, which a machine with a graphics card does not show."""
    page.evaluate(
        """() => { for (const note of document.querySelectorAll('[class*=Notification-root]'))
             if (/webgl/i.test(note.textContent)) note.querySelector('button')?.click(); }"""
    )


@contextmanager
def drawn(page: Page) -> Iterator[None]:
    """What the page draws is filled meanwhile, beginning with its present picture."""
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
    """Save a picture if `DUET_ARTIFACTS` names a folder for pictures: each takes two seconds to draw."""
    if os.environ.get("DUET_ARTIFACTS"):
        save_picture(page, name)


def wait_frames(page: Page, count: int = 2) -> None:
    page.evaluate(
        "n => new Promise(done => { const step = () => (n-- > 0 ? requestAnimationFrame(step) : done()); step(); })",
        count,
    )


BETWEEN = 3
"""Drawn frames between two questions to a page: to ask after every one costs as much as the page itself."""


def until(page: Page, true: Callable[[], object], what: str = "it", seconds: float = 60.0) -> None:
    """Return as soon as something is true, asked again after every few drawn frames."""
    deadline = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < deadline, f"{what}: not within {seconds:g} s"
        wait_frames(page, BETWEEN)


WELCOMED = "try { localStorage.duetWelcome ??= '1'; localStorage.duetPanel ??= 'all'; } catch {}"
"""A browser's first script with which no welcome is shown, and every setting is."""


def lasting(page: Page, faults: Callable[[], list[str]]) -> list[str]:
    """Return the faults that a page keeps for so long: a slow machine may still be at work on it when it is looked at first."""
    found: list[str] = []

    def none() -> bool:
        found[:] = faults()
        return not found

    with suppress(AssertionError):
        until(page, none, "a page without faults")
    return found


CAMERA = "[...__viserMutable.camera.position.toArray(), ...__viserMutable.camera.quaternion.toArray()]"


STILL = 1.5
"""A view has settled if it has stayed for so long [s]: what the page says of its layout arrives that much apart."""


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
    """The camera, once it has been put right for the page's layout and has stayed where it is, for `frames` drawn frames, too."""
    return _settled(page, lambda: page.evaluate(CAMERA), frames, "a view that stays")


def settled_box(page: Page, place: Locator) -> np.ndarray:
    """Left, top, width and height [px] of what a mouse is to find, once the page around it has come to rest."""

    def look() -> list[float]:
        box = place.bounding_box()
        return [np.nan] * 4 if box is None else [box["x"], box["y"], box["width"], box["height"]]

    return _settled(page, look, 5, "a place that stays")


_CANVAS = "(__viserMutable.canvas.querySelector?.('canvas') ?? document.querySelector('canvas[data-engine]'))"


def wait_ready(page: Page, node: str) -> None:
    """Wait until the scene node `node` exists and the canvas has faded in."""
    page.wait_for_function(
        f"name => window.__viserMutable?.nodeRefFromName?.[name] && +{_CANVAS}?.style.opacity === 1"
        " && (document.documentElement.matches('.duet-built') || !document.getElementById('duet-loading'))",
        arg=node,
        timeout=60_000,
    )
    wait_frames(page)


def world_position(page: Page, node: str) -> np.ndarray:
    """Where the page has drawn the origin of a node, in the scene's coordinates (z up).

    Not for a gizmo under the mouse: until the server moves it, its node stays where the drag began.
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
    """Move the mouse to a point of the scene, which nothing may cover, and wait until the page has seen it there."""
    x, y = world_to_px(page, point)
    on_top = page.evaluate("([x, y]) => document.elementFromPoint(x, y) === __viserMutable.canvas", [x, y])
    assert on_top, f"something covers the scene at ({x:.0f}, {y:.0f}) px"
    page.mouse.move(x, y)
    wait_frames(page, 3)


def take_hold(page: Page, point: Callable[[], np.ndarray], held: Callable[[], object]) -> None:
    """Press the mouse on a handle, and again if the view or the handle was still on its way.

    Args:
        page: a tab wider than 576 px.
        point: where to take it, in the scene; asked before every attempt.
        held: whether it is dragged; after five attempts without, an AssertionError.
    """
    for attempt in range(1, 6):
        settled_view(page, 5)
        x, y = world_to_px(page, point())
        # A handle looks for the pointer when it moves, so it must have seen it there before the button goes down.
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
