"""The controls, made from the settings' own declarations: a slider, a drop-down or a box for every field a visitor may change."""

from collections.abc import Callable, Iterable
from typing import Any, Final

import viser

from app.i18n.speaking import spoken, tr, tr_all
from app.page.panels.choice_buttons import ChoiceButtons
from app.page.panels.compare import ComparePanel
from app.page.panels.hotkeys import help_html
from app.page.panels.joint_sliders import JointSliders
from app.page.panels.source_chooser import Sources
from app.session.actions import Action, Pause, Reset, SetSetting, SingleStep
from app.session.clock import SPEEDS
from app.session.frame import Frame, freeze
from app.session.relevant_settings import matters
from app.session.session import Session
from app.settings import Settings
from app.web.viser_internals import container_uuid_of, uuid_of
from scenes.setting_spec import Spec
from scenes.settings import specs, values

PICKER: Final = ("scene", "robot", "rig")
"""Settings above everything else: which experiment."""

TABS: Final[tuple[tuple[str, viser.IconName, tuple[str, ...]], ...]] = (
    (
        "Law",
        viser.Icon.ADJUSTMENTS_HORIZONTAL,
        ("law", "dm", "n", "v", "d0", "eta", "gamma", "kr", "k", "kx", "pairs", "beta", "eps", "ff", "one_sided", "coupled"),
    ),
    (
        "Arms",
        viser.Icon.ROBOT,
        (
            *("path", "point", "ball", "source", "clip", "following", "task", "guided", "avoid", "start"),
            *("autopilot", "gizmo", "wmax", "seed", "dt", "bounds", "g"),
        ),
    ),
    ("Robot", viser.Icon.CPU, ("dead", "lag", "qnoise", "qstep", "fps", "dnoise")),
    ("Compare", viser.Icon.GHOST, ("ghost", "whatif")),
    ("View", viser.Icon.EYE, ("lang", "theme", "profile", "picture", "contact")),
)
"""Where each of the others is found; `plot` and `speed` have places of their own."""

UNOFFERED: Final = ("pseudo",)
"""Choices that only a link can ask for."""

COMPARE: Final = (
    "A ghost does the same experiment under the same hand, with another law or with the settings of this moment: a translucent arm, "
    "dashed lines in the plots, and a ring on the line of contact."
)

ROBOT: Final = (
    "What lies between the law and a real arm, of the arms that keep clear: 0 everywhere is the ideal robot. With a dead time T the rest "
    "is stable as long as a T &lt; π/2, and d does not overshoot up to a T = 1/e."
)

NOTHING_NEAR: Final = "There is nothing to keep clear of here, so that every law does the same."

Handle = Any


class Controls:
    """All controls of one session.

    Args:
        post: has an action done on the session's thread.
        notify: shows a message to the visitor.
        presenting: whether a class watches, so that some keys are the presenter's.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        session: Session,
        post: Callable[[Action], None],
        notify: Callable[[str, str], None],
        presenting: bool = False,
    ) -> None:
        self._gui, self._session, self._post = gui, session, post
        self._specs: dict[str, Spec] = specs(Settings)
        self._handles: dict[str, Handle] = {}
        self._shown: dict[str, Any] = {}
        self._settings: Settings | None = None
        present = values(session.settings)
        for place, key in enumerate(PICKER):
            # Above the numbers, which were made before.
            self._handles[key] = self._control(key, self._specs[key], present[key], order=place - len(PICKER))
        self._transport()
        self._tabs = gui.add_tab_group()
        for name, icon, keys in TABS:
            with self._tabs.add_tab(tr(name), icon):
                for key in keys:
                    self._handles[key] = self._control(key, self._specs[key], present[key])
                if name == "Arms":
                    self._sources = Sources(gui, session, notify)
                    self._joints = JointSliders(gui, session, post)
                if name == "Robot":
                    gui.add_html(f'<div class="duet duet-tip">{tr(ROBOT)}</div>')
                if name == "Compare":
                    self._compare = ComparePanel(gui, session)
                    self._note = gui.add_html("")
        with self._tabs.add_tab(tr("Keys"), viser.Icon.KEYBOARD):
            gui.add_html(f'<div class="duet">{help_html(presenting)}</div>')
        self.show(freeze(session, 0.0))

    @property
    def below_clock(self) -> float:
        """Order of what is to stand between the clock and the tabs."""
        return self._tabs.order - 0.5

    def _transport(self) -> None:
        gui = self._gui
        actions = (Pause(), SingleStep(), Reset())
        self._clock = ChoiceButtons(
            gui,
            "clock",
            ("Pause", "Step", "Reset"),
            "Space pauses and goes on, . makes one step, R restarts the run.",
            lambda i: self._post(actions[i]),
        )
        labels = tuple({0.25: "¼×", 0.5: "½×", 1.0: "1×", 2.0: "2×"}[speed] for speed in SPEEDS)
        self._speed = ChoiceButtons(
            gui, "speed", labels, "Slower and faster: [ and ].", lambda i: self._post(SetSetting("speed", SPEEDS[i]))
        )

    def _control(self, key: str, spec: Spec, value: Any, order: float | None = None) -> Handle:
        gui, label = self._gui, spec.title(tr)
        if spec.choices:
            said = tr_all(spec.choice_labels)
            handle: Handle = gui.add_dropdown(
                label,
                tuple(s for c, s in zip(spec.choices, said, strict=True) if c not in UNOFFERED or c == value),
                initial_value=said[spec.choices.index(value)],
                hint=tr(spec.help),
                order=order,
            )
        elif isinstance(value, bool):
            handle = gui.add_checkbox(label, value, hint=tr(spec.help))
        elif isinstance(value, int):
            handle = gui.add_number(label, value, min=int(spec.low), max=int(spec.high), step=1, hint=tr(spec.help))
        else:
            k = spec.page_scale
            handle = gui.add_slider(label, spec.low * k, spec.high * k, spec.step, _rounded(value * k), hint=tr(spec.help))
        self._shown[key] = value
        words = spoken()

        @handle.on_update
        async def _(event: viser.GuiEvent[Any]) -> None:
            # What the server writes comes back here too, without a client.
            if event.client_id is None:
                return
            raw = event.target.value
            if spec.choices:
                labels = tuple(map(words, spec.choice_labels))
                raw = spec.choices[labels.index(raw)] if raw in labels else raw
            elif isinstance(raw, float):
                raw /= spec.page_scale
            self._post(SetSetting(key, raw))

        return handle

    def places(self, keys: Iterable[str]) -> tuple[tuple[str, str], ...]:
        """Return for every setting by which names the page knows its control, and the tab in which that stands."""
        handles = [self._handles[key] for key in keys if key in self._handles]
        return tuple((uuid_of(handle), container_uuid_of(handle)) for handle in handles)

    def forget(self, key: str) -> None:
        """Write a setting back into its control at the next frame: the value there was refused."""
        self._shown.pop(key, None)

    def show(self, frame: Frame) -> None:
        """Write what was changed elsewhere (keys, the gizmo, a refused value) back into the controls; hide what does not matter."""
        self._clock.show(0 if frame.pace.paused else -1)
        settings = self._session.settings
        self._sources.show(frame)
        self._joints.show(frame)
        self._compare.show(frame)
        if settings is self._settings and len(self._shown) == len(self._handles):
            return
        self._settings = settings
        present = values(settings)
        self._speed.show(SPEEDS.index(present["speed"]) if present["speed"] in SPEEDS else -1)
        for key, handle in self._handles.items():
            handle.visible = matters(key, settings)
            if key in self._shown and self._shown[key] == present[key]:
                continue
            value, spec = present[key], self._specs[key]
            self._shown[key] = value
            if spec.choices:
                handle.value = tr(spec.choice_labels[spec.choices.index(value)])
            elif isinstance(value, float):
                if abs(handle.value / spec.page_scale - value) > 1e-9:
                    handle.value = _rounded(value * spec.page_scale)
            else:
                handle.value = value
        note = tr(COMPARE) if matters("ghost", settings) else tr(NOTHING_NEAR)
        self._note.content = f'<div class="duet duet-tip">{note}</div>'


def _rounded(value: float) -> float:
    """Return a page value without the last bits of its conversion: 150.0, not 150.00000000000003."""
    return float(f"{value:.9g}")
