"""Helpers for visitors without a browser: they operate a page and read it."""

import html
from typing import Any

from app.page.panels.choice_buttons import MARK
from app.page.panels.controls import PICKER, TABS
from app.page.panels.hotkeys import hotkeys
from app.session.relevant_settings import matters
from app.session.session import Session
from app.settings import Settings
from app.web.headless_client import HeadlessClient
from scenes.settings import specs
from tests.app.conftest import Guest, ask
from tests.blocking_client import BlockingClient

Client = BlockingClient | HeadlessClient
SPECS = specs(Settings)
ON_PAGE = (*PICKER, *(key for _, _, keys in TABS for key in keys))
USUAL_STAGE = {"scene": "hold", "law": "smooth_priority"}
STAGES: dict[str, dict[str, Any]] = {
    **{key: {"scene": "solo"} for key in ("path", "kx")},
    **{key: {"scene": "ball"} for key in ("point", "ball")},
    **{key: {"scene": "imitation", "source": "clips"} for key in ("source", "clip")},
    **{key: {"scene": "first_task", "first": "all"} for key in ("first", "together", "load")},
    "following": {"scene": "master_slave"},
    "start": {"rig": "torso", "robot": "lwr"},
    **{key: {"law": "potential_field"} for key in ("d0", "eta")},
    "gamma": {"law": "barrier_qp"},
    "kr": {"law": "set_based_task"},
    "curve": {"law": "drawn_curve"},
    "lever": {"law": "lever"},
    "beta": {"pairs": "soft"},
    "eps": {"pairs": "smooth"},
    "coupled": {"avoid": "both", "ff": False},
}
"""Key → settings that show its control. Controls that are not listed are visible by default."""


def page_label(key: str) -> str:
    """Label of a control."""
    return SPECS[key].title()


def bring_into_view(session: Session, key: str) -> None:
    def choose(s: Session) -> None:
        for k, value in (USUAL_STAGE | STAGES.get(key, {})).items():
            s.change(k, value)

    if not matters(key, session.settings):
        ask(session, choose)
    assert matters(key, session.settings), key


def another(key: str, present: Any) -> tuple[Any, Any]:
    """A valid value other than the present one, as the page sends it and as the settings store it."""
    spec = SPECS[key]
    if spec.choices:
        other = spec.choices[(spec.choices.index(present) + 1) % len(spec.choices)]
        return spec.options()[other], other
    if spec.read is not None:
        other = "0.1:1,0.3:0" if present != "0.1:1,0.3:0" else "0.1:1,0.2:0"
        return other, other
    if isinstance(present, bool):
        return not present, not present
    if isinstance(present, int):
        return present + 41, present + 41
    page = spec.low * spec.page_scale + 3.0 * spec.step
    if abs(page / spec.page_scale - present) < 1e-9:
        page += spec.step
    return page, page / spec.page_scale


def hotkey_uuid(visitor: BlockingClient, action: str) -> str:
    """uuid of the palette command of a hotkey."""
    text = next(h.text for h in hotkeys() if h.name == action).capitalize()
    return next(uuid for uuid, command in list(visitor.mirror.commands.items()) if command["label"] == text)


def press(guest: Guest, action: str) -> None:
    """Press a hotkey, and wait until the server has processed it."""
    guest.visitor.send({"type": "CommandTriggerMessage", "uuid": hotkey_uuid(guest.visitor, action)})
    roundtrip(guest)


def roundtrip(guest: Guest) -> None:
    """Wait until the server has processed all earlier messages of the visitor, which it reads in order."""
    before = guest.session.settings.run.limit_gain
    value = before + 0.5 if before < 20.0 else before - 5.5
    guest.visitor.set_value(page_label("g"), value)
    guest.wait(lambda s: abs(s.settings.run.limit_gain - value) < 1e-9)


def bodies(visitor: Client, kind: str) -> list[dict[str, Any]]:
    """Visible GUI elements of a kind, in order of arrival."""
    elements = list(visitor.mirror.gui.values())
    return [element for element in elements if element["type"] == kind and element.get("visible", True)]


def shown(visitor: Client) -> str:
    """All visible texts, with plain spaces for no-break spaces."""
    elements = list(visitor.mirror.gui.values())
    texts = " ".join(str(e.get("content") or "") for e in elements if e.get("visible", True))
    return html.unescape(texts).replace("\N{NO-BREAK SPACE}", " ")


def buttons(visitor: Client) -> list[str]:
    """Labels of the visible buttons, without the mark of the chosen one."""
    return [str(button["label"]).removeprefix(MARK) for button in bodies(visitor, "GuiButtonMessage")]


def click(visitor: BlockingClient, start: str) -> None:
    """Press the visible button with a label that begins with `start`."""
    found: list[str] = []

    def is_there(_: object) -> bool:
        # Its label may change a moment later.
        elements = bodies(visitor, "GuiButtonMessage")
        found[:] = [e["uuid"] for e in elements if str(e["label"]).removeprefix(MARK).startswith(start)]
        return bool(found)

    visitor.wait_for(is_there, 60.0)
    visitor.send({"type": "GuiUpdateMessage", "uuid": found[0], "updates": {"value": True}})


def open_lessons(visitor: BlockingClient) -> None:
    """Open the first lesson from the list."""
    click(visitor, "Lessons")
    click(visitor, "1  ")


def notes(visitor: Client) -> list[str]:
    return [str(note["body"]) for note in bodies(visitor, "NotificationShowMessage")]
