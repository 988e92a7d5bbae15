"""Controls made from the declarations of the settings."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
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
from app.text.first_task_texts import in_symbols, in_unit, said_of, wording
from app.text.templates import element, tr_html
from app.web.control_events import on_entry
from app.web.viser_internals import container_uuid_of, uuid_of
from scenes.quantities import DISTANCE, FIRST_TASKS, KeptQuantity
from scenes.setting_spec import Spec
from scenes.settings import ABOVE, specs, values


def _keys_of(tab: str) -> tuple[str, ...]:
    found = [spec for spec in specs(Settings).values() if spec.tab.name == tab]
    return tuple(spec.key for spec in sorted(found, key=lambda spec: spec.tab.place))


PICKER: Final = _keys_of(ABOVE.name)

SMALL: Final = ("scene", "first", "together", "load", "law", "dm", "n", "v", "k")

TABS: Final[tuple[tuple[str, viser.IconName, tuple[str, ...]], ...]] = (
    ("Law", viser.Icon.ADJUSTMENTS_HORIZONTAL, _keys_of("Law")),
    ("Arms", viser.Icon.ROBOT, _keys_of("Arms")),
    ("Robot", viser.Icon.CPU, _keys_of("Robot")),
    ("Compare", viser.Icon.GHOST, _keys_of("Compare")),
    ("View", viser.Icon.EYE, _keys_of("View")),
)
"""`plot` and `speed` have their own places."""

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

BELOW: Final = 1e6
"""Order at the end of a tab."""


class Controls:
    """All controls of one session.

    Args:
        phone: True adds a button for the first view.

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
        self._speak_of(session.settings.run.quantity)
        present = values(session.settings)
        for place, key in enumerate(PICKER):
            # Above the numbers, which were made before.
            self._handles[key] = self._control(key, present[key], order=place - len(PICKER))
        self._transport()
        self._tabs = gui.add_tab_group()
        handlers.add(TakeDrawing, lambda action: action.board.take(action.text))
        for name, icon, keys in TABS:
            with self._tabs.add_tab(tr(name), icon) as tab:
                for key in keys:
                    self._handles[key] = self._control(key, present[key])
                if name == "Arms":
                    self._joints, self.arms_tab = JointSliders(gui, session), tab
                if name == "Robot":
                    self._robot = gui.add_html(self._about_robot())
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
            {"Pause": Pause(), N_("Continue"): Pause(), "Step": SingleStep(), "Reset": Reset()},
            "Space: pause or continue. Full stop: one step. R: restart the run.",
            self._session.post,
        )
        self.below_transport = self._clock.order + 0.5
        speeds = {
            {0.25: "¼×", 0.5: "½×", 1.0: "1×", 2.0: "2×"}[speed]: SetSetting("speed", speed)
            for speed in SPEEDS
        }
        self._speed = ChoiceButtons(gui, "speed", speeds, "Slower and faster: [ and ].", self._session.post)

    def _speak_of(self, kept: KeptQuantity) -> None:
        self._quantity, self._say = kept, said_of(kept)
        self._said = {key: in_unit(spec, kept) for key, spec in self._specs.items()}

    def _control(self, key: str, value: Any, order: float | None = None) -> Any:
        gui, spec, say = self._gui, self._said[key], self._say
        label = spec.title(say)
        if spec.choices:
            handle: Any = gui.add_dropdown(
                label,
                _offered(spec, value, say),
                initial_value=say(spec.options()[value]),
                hint=say(spec.help),
                order=order,
            )
        elif spec.read is not None:
            self._curve = CurveControl(gui, self._session, key, label, say(spec.help), value)
            return self._curve.box
        elif isinstance(value, bool):
            handle = gui.add_checkbox(label, value, hint=say(spec.help), order=order)
        elif isinstance(value, int):
            low, high = int(spec.low), int(spec.high)
            handle = gui.add_number(label, value, min=low, max=high, step=1, hint=say(spec.help), order=order)
        else:
            k = spec.page_scale
            low, high = spec.low * k, spec.high * k
            handle = gui.add_slider(
                label, low, high, spec.step, _rounded(value * k), hint=say(spec.help), order=order
            )
        words, more = spoken(), tr(MORE)

        def take(raw: Any) -> None:
            if key == "law" and raw == more:
                self._session.post(MoreLaws())
                return
            if spec.choices:
                raw = _choice_of(raw, self._specs[key], words)
            elif isinstance(raw, float):
                raw /= spec.page_scale
            self._session.post(SetSetting(key, raw))

        return on_entry(handle, take)

    def places(self, keys: Iterable[str]) -> tuple[tuple[str, str], ...]:
        """Ids of each setting's control and its tab."""
        handles = [self._handles[key] for key in keys if key in self._handles]
        return tuple((uuid_of(handle), container_uuid_of(handle)) for handle in handles)

    def add_twin(self, key: str, order: float) -> None:
        """Add a second control in the open container."""
        self.twins[key] = self._control(key, values(self._session.settings)[key], order)

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
        """Restore the controls after a refused value."""
        self._settings = None

    def fold(self, whole: bool, plays: bool) -> None:
        """`whole`: the visitor's choice; `plays`: True if few controls suffice now."""
        if (whole, plays) == self._folded:
            return
        self._folded, self.small, self._settings = (whole, plays), plays and not whole, None
        kinds = f"duet-panel{' duet-small' * self.small}"
        self._panel_kinds = kinds, "all" if whole else "small"
        self._mark_panel()
        # The few controls have their own button for the view.
        offered = ((int(whole),) if plays else ()) + ((2,) if self._phone and not self.small else ())
        self._further.show(offered=offered, visible=bool(offered))

    def _handles_of(self, key: str) -> Iterator[Any]:
        yield self._handles[key]
        if key in self.twins:
            yield self.twins[key]

    def _about_robot(self) -> str:
        return element("div", in_symbols(tr_html(ROBOT), self._quantity), class_="duet duet-tip")

    def _write_words(self, present: Mapping[str, Any]) -> None:
        say = self._say
        for key in self._handles:
            spec = self._said[key]
            for handle in self._handles_of(key):
                handle.label, handle.hint = spec.title(say), say(spec.help)
                if spec.choices:
                    handle.options = _offered(spec, present[key], say)
        self._robot.content = self._about_robot()

    def show(self, frame: Frame) -> None:
        """Show changes made elsewhere; hide controls that do not matter."""
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
        if settings.run.quantity is not self._quantity:
            self._speak_of(settings.run.quantity)
            self._write_words(present)
        self._law.show(present["law"], self.small, self._say)
        for key, handle in self._handles.items():
            if handle is self._curve.box:
                continue
            handle.visible = matters(key, settings) and (key in SMALL or not self.small)
            # A visitor's newest entry wins, see `app/web/entries.py`.
            for each in self._handles_of(key):
                _write(each, self._said[key], present[key], self._say)
        note = (
            tr_html(wording(COMPARE, self._quantity)) if matters("ghost", settings) else tr_html(NOTHING_NEAR)
        )
        self._note.content = element("div", note, class_="duet duet-tip")


def _offered(spec: Spec, value: Any, say: Callable[[str], str]) -> tuple[str, ...]:
    return tuple(
        say(text) for choice, text in spec.options().items() if choice not in UNOFFERED or choice == value
    )


def _choice_of(entered: Any, spec: Spec, words: Callable[[str], str]) -> Any:
    """Choice by its text for any first task, which may have changed meanwhile."""
    for kept in (DISTANCE, *FIRST_TASKS.values()):
        for choice, text in in_unit(spec, kept).options().items():
            if in_symbols(words(text), kept) == entered:
                return choice
    return entered


def _write(handle: Any, spec: Spec, value: Any, say: Callable[[str], str]) -> None:
    if spec.choices:
        handle.value = say(spec.options()[value])
    elif isinstance(value, float):
        if abs(handle.value / spec.page_scale - value) > 1e-9:
            handle.value = _rounded(value * spec.page_scale)
    else:
        handle.value = value


def _rounded(value: float) -> float:
    """Value without rounding errors, such as 150.00000000000003."""
    return float(f"{value:.9g}")
