"""Controls made from the declarations of the settings."""

from collections.abc import Iterable, Sequence
from typing import Any, Final

import viser

from app.i18n.speaking import N_, spoken, tr
from app.page.panels.choice_buttons import ChoiceButtons
from app.page.panels.curve_control import CurveControl
from app.page.panels.drawing_board import TakeDrawing
from app.page.panels.hotkeys import Hotkey, KeyHelp, help_html
from app.page.panels.joint_sliders import JointSliders
from app.page.panels.law_choice import MORE, LawChoice, MoreLaws
from app.session.action_handlers import ActionHandlers
from app.session.actions import FirstView, Pause, Reset, SetSetting, ShowAll, SingleStep
from app.session.clock import SPEEDS
from app.session.frame import Frame, freeze
from app.session.relevant_settings import matters
from app.session.session import Session
from app.settings import Settings
from app.text.first_task_texts import in_unit
from app.text.templates import element, tr_html
from app.web.control_events import on_entry
from app.web.viser_internals import container_uuid_of, uuid_of
from scenes.setting_spec import Spec
from scenes.settings import ABOVE, specs, values


def _keys_of(tab: str) -> tuple[str, ...]:
    found = [spec for spec in specs(Settings).values() if spec.tab.name == tab]
    return tuple(spec.key for spec in sorted(found, key=lambda spec: spec.tab.place))


PICKER: Final = _keys_of(ABOVE.name)
"""The experiment: above everything else."""

SMALL: Final = ("scene", "first", "together", "load", "law", "dm", "n", "v", "k")
"""Settings of the few controls."""

TABS: Final[tuple[tuple[str, viser.IconName, tuple[str, ...]], ...]] = (
    ("Law", viser.Icon.ADJUSTMENTS_HORIZONTAL, _keys_of("Law")),
    ("Arms", viser.Icon.ROBOT, _keys_of("Arms")),
    ("Robot", viser.Icon.CPU, _keys_of("Robot")),
    ("Compare", viser.Icon.GHOST, _keys_of("Compare")),
    ("View", viser.Icon.EYE, _keys_of("View")),
)
"""Tab of each other setting; `plot` and `speed` have their own places."""

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


IN_UNIT: Final = ("dm", "d0", "v")
"""Settings whose unit is that of the first task."""

BELOW: Final = 1e6
"""Order at the end of a tab."""


class Controls:
    """All controls of one session.

    Args:
        instead: keys with another meaning on this page.
        phone: whether keys without a control become buttons.
        key_help: rows of features for the table of keys.

    Attributes:
        twins: second controls of settings, by key.
        small: True while few controls are shown.
        below_transport: order between the clock's buttons and the settings.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        session: Session,
        handlers: ActionHandlers,
        instead: tuple[Hotkey[Any], ...] = (),
        phone: bool = False,
        key_help: Sequence[KeyHelp] = (),
    ) -> None:
        self.small, self._phone = False, phone
        self._folded: tuple[bool, bool] | None = None
        self._gui, self._session = gui, session
        self._specs: dict[str, Spec] = specs(Settings)
        self._handles: dict[str, Any] = {}
        self.twins: dict[str, Any] = {}
        self._settings: Settings | None = None
        present = values(session.settings)
        for place, key in enumerate(PICKER):
            # Above the numbers, which were made before.
            self._handles[key] = self._control(key, self._specs[key], present[key], order=place - len(PICKER))
        self._transport()
        self._tabs = gui.add_tab_group()
        handlers.add(TakeDrawing, lambda action: action.board.take(action.text))
        for name, icon, keys in TABS:
            with self._tabs.add_tab(tr(name), icon) as tab:
                for key in keys:
                    self._handles[key] = self._control(key, self._specs[key], present[key])
                if name == "Arms":
                    self._joints, self.arms_tab = JointSliders(gui, session), tab
                if name == "Robot":
                    gui.add_html(element("div", tr_html(ROBOT), class_="duet duet-tip"))
                if name == "Compare":
                    self.compare_tab = tab
                    # Below what features add to the tab.
                    self._note = gui.add_html("", order=BELOW)
        self._law = LawChoice(self._handles["law"], self._specs["law"], UNOFFERED)
        handlers.add(MoreLaws, self._offer_all_laws)
        with self._tabs.add_tab(tr("Keys"), viser.Icon.KEYBOARD):
            gui.add_html(element("div", "", help_html(instead, key_help), class_="duet"))
        self._panel = gui.add_html("")
        further = {
            N_("All settings"): ShowAll(),
            N_("Fewer settings"): ShowAll(False),
            N_("First view"): FirstView(),
        }
        self._further = ChoiceButtons(gui, "", further, "", session.post)
        self.show(freeze(session, 0.0))

    @property
    def below_clock(self) -> float:
        return self._tabs.order - 0.5

    def _transport(self) -> None:
        gui = self._gui
        self._clock = ChoiceButtons(
            gui,
            "clock",
            {"Pause": Pause(), N_("Go on"): Pause(), "Step": SingleStep(), "Reset": Reset()},
            "Space pauses and goes on, . makes one step, R restarts the run.",
            self._session.post,
        )
        self.below_transport = self._clock.order + 0.5
        speeds = {
            {0.25: "¼×", 0.5: "½×", 1.0: "1×", 2.0: "2×"}[speed]: SetSetting("speed", speed)
            for speed in SPEEDS
        }
        self._speed = ChoiceButtons(gui, "speed", speeds, "Slower and faster: [ and ].", self._session.post)

    def _control(self, key: str, spec: Spec, value: Any, order: float | None = None) -> Any:
        gui, label = self._gui, spec.title(tr)
        if spec.choices:
            said = {choice: tr(text) for choice, text in spec.options().items()}
            handle: Any = gui.add_dropdown(
                label,
                tuple(said[c] for c in said if c not in UNOFFERED or c == value),
                initial_value=said[value],
                hint=tr(spec.help),
                order=order,
            )
        elif spec.read is not None:
            self._curve = CurveControl(gui, self._session, label, spec, value)
            return self._curve.box
        elif isinstance(value, bool):
            handle = gui.add_checkbox(label, value, hint=tr(spec.help), order=order)
        elif isinstance(value, int):
            low, high = int(spec.low), int(spec.high)
            handle = gui.add_number(label, value, min=low, max=high, step=1, hint=tr(spec.help), order=order)
        else:
            k = spec.page_scale
            low, high = spec.low * k, spec.high * k
            handle = gui.add_slider(
                label, low, high, spec.step, _rounded(value * k), hint=tr(spec.help), order=order
            )
        words, more = spoken(), tr(MORE)

        def take(raw: Any) -> None:
            if key == "law" and raw == more:
                self._session.post(MoreLaws())
                return
            if spec.choices:
                raw = {words(text): choice for choice, text in spec.options().items()}.get(raw, raw)
            elif isinstance(raw, float):
                raw /= spec.page_scale
            self._session.post(SetSetting(key, raw))

        return on_entry(handle, take)

    def places(self, keys: Iterable[str]) -> tuple[tuple[str, str], ...]:
        """Each setting's control by its names on the page, and its tab."""
        handles = [self._handles[key] for key in keys if key in self._handles]
        return tuple((uuid_of(handle), container_uuid_of(handle)) for handle in handles)

    def add_twin(self, key: str, order: float) -> None:
        """Add a second control of a setting in the open container."""
        self.twins[key] = self._control(key, self._specs[key], values(self._session.settings)[key], order)

    def _mark_panel(self, opens: str | None = None) -> None:
        """`opens`: id of a drop-down to open."""
        kinds, panel = self._panel_kinds
        self._panel.content = element(
            "i", class_=kinds, data_panel=panel, **({"data_opens": opens} if opens else {})
        )

    def _offer_all_laws(self, action: MoreLaws) -> None:
        del action
        self._law.all = True
        self.write_again()
        self._mark_panel(opens=uuid_of(self._handles["law"]))

    def write_again(self) -> None:
        """Restore the controls at the next frame, after a refused value."""
        self._settings = None

    def fold(self, whole: bool, plays: bool) -> None:
        """`whole`: the visitor's choice; `plays`: whether few controls can be enough now."""
        if (whole, plays) == self._folded:
            return
        self._folded, self.small, self._settings = (whole, plays), plays and not whole, None
        kinds = f"duet-panel{' duet-small' * self.small}"
        self._panel_kinds = kinds, "all" if whole else "small"
        self._mark_panel()
        # The few controls have their own button for the view.
        offered = ((int(whole),) if plays else ()) + ((2,) if self._phone and not self.small else ())
        self._further.show(offered=offered, visible=bool(offered))

    def show(self, frame: Frame) -> None:
        """Write other changes (keys, gizmo, refused values) into the controls; hide what does not matter."""
        steps = () if self.small else (2,)
        self._clock.show(offered=(int(frame.pace.paused), *steps, 3))
        settings = frame.live.settings
        self._joints.show(frame)
        self._curve.show(settings, matters("curve", settings))
        if settings is self._settings:
            return
        self._settings = settings
        present = values(settings)
        self._speed.show(
            SPEEDS.index(present["speed"]) if present["speed"] in SPEEDS else -1, visible=not self.small
        )
        self._law.show(present["law"], self.small)
        for key, handle in self._handles.items():
            if handle is self._curve.box:
                continue
            handle.visible = matters(key, settings) and (key in SMALL or not self.small)
            # A visitor's newest entry wins, see `app/web/entries.py`.
            for each in (handle, *([self.twins[key]] if key in self.twins else ())):
                _write(each, self._specs[key], present[key])
            if key in IN_UNIT:
                spec = in_unit(self._specs[key], settings.run.quantity)
                handle.label, handle.hint = spec.title(tr), tr(spec.help)
        note = tr_html(COMPARE) if matters("ghost", settings) else tr_html(NOTHING_NEAR)
        self._note.content = element("div", note, class_="duet duet-tip")


def _write(handle: Any, spec: Spec, value: Any) -> None:
    if spec.choices:
        handle.value = tr(spec.options()[value])
    elif isinstance(value, float):
        if abs(handle.value / spec.page_scale - value) > 1e-9:
            handle.value = _rounded(value * spec.page_scale)
    else:
        handle.value = value


def _rounded(value: float) -> float:
    """Value without the last bits of its conversion: 150.0, not 150.00000000000003."""
    return float(f"{value:.9g}")
