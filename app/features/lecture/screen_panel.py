"""The teacher's remote control of the projector."""

from urllib.parse import urlencode

import viser
from markupsafe import Markup

from app.features.lecture.presenter import STATION_NAMES, TIMERS, Presenter, Station, clock_text
from app.features.lecture.teacher_control import Teach, TeacherControl
from app.i18n.speaking import N_, tr
from app.page.panels.choice_buttons import ChoiceButtons
from app.settings import PageSettings
from app.text.templates import macros
from app.web.control_events import on_press


class ScreenPanel:
    """The controls, in the caller's open tab."""

    def __init__(self, gui: viser.GuiApi, control: TeacherControl, keyed: bool) -> None:
        self._presenter, self._lessons, act = control.presenter, control.lessons, control.post
        self._shown: object = None
        self._state = gui.add_html("")
        self._on = gui.add_button("", icon=viser.Icon.ARROW_DOWN)
        self._back = gui.add_button(tr("Back"), color="gray", icon=viser.Icon.ARROW_UP)
        self._timer = ChoiceButtons(
            gui,
            "timer",
            {f"{seconds} s" if seconds else N_("Off"): Teach(action) for action, seconds in TIMERS.items()},
            "Everybody sees the remaining time. After it, answers still count until the reveal.",
            control.session.post,
        )
        self._picture = ChoiceButtons(
            gui,
            "screen",
            {"Live": Teach("live"), "Frozen": Teach("freeze"), "Black": Teach("blank")},
            "Frozen: the screen keeps its picture while you prepare something. Page ↓ brings it back.",
            control.session.post,
        )
        self._layout = ChoiceButtons(
            gui,
            "shows",
            {"3-D view alone": Teach("stage"), "With panels": Teach("panels")},
            "With panels: lesson and plots next to the 3-D view, as students see them.",
            control.session.post,
        )
        gui.add_html(open_html(control.session.settings.page, keyed))
        on_press(self._on, lambda: act("on"))
        on_press(self._back, lambda: act("back"))

    def show(self) -> None:
        presenter, lessons = self._presenter, self._lessons
        following = presenter.following(lessons.walk) if lessons.open else None
        cover = presenter.covered, presenter.blank, presenter.frozen, presenter.inviting, presenter.panels
        shown = lessons.open, presenter.station, following, cover, presenter.screens
        if shown == self._shown:
            return
        self._shown = shown
        pills = (
            [("", tr("On the screen: {what}", what=tr(STATION_NAMES[presenter.station])))]
            if lessons.open
            else []
        )
        pills.append(("", tr("screens: {count}", count=presenter.screens)))
        self._state.content = macros("page/panels/pills.html").in_class([pills], live=True)
        self._on.label = next_station_label(presenter, following)
        self._on.disabled = self._back.disabled = not (lessons.open or presenter.covered)
        self._timer.show(visible=lessons.open)
        self._picture.show(2 if presenter.blank else 1 if presenter.frozen else 0)
        self._layout.show(1 if presenter.panels else 0)


def next_station_label(presenter: Presenter, following: Station | None) -> str:
    """Effect of Page ↓. `following`: None if the next step follows."""
    if presenter.covered:
        return tr("Next: the picture again")
    return tr("Next step") if following is None else tr("Next: {what}", what=tr(STATION_NAMES[following]))


def covers_html(presenter: Presenter) -> Markup:
    pills: list[tuple[str, str]] = []
    if presenter.blank:
        pills.append(("halt", tr("the screen is black")))
    elif presenter.frozen:
        pills.append(("halt", tr("the screen is frozen")))
    if presenter.inviting:
        where = (
            tr("the address is on every page")
            if presenter.inviting == "all"
            else tr("the address is on the screen")
        )
        pills.append(("halt", where))
    if presenter.left == 0:
        pills.append(("halt", tr("Time is up.")))
    elif presenter.left is not None:
        pills.append(("go", tr("time left: {time}", time=clock_text(presenter.left))))
    elif presenter.asked_for is not None:
        pills.append(("", tr("asked for {time}", time=clock_text(presenter.asked_for))))
    return macros("page/panels/pills.html").in_class([pills], live=True) if pills else Markup()


def open_html(page: PageSettings, keyed: bool) -> Markup:
    query = {"screen": "1", "profile": "projector"} | (
        {} if page.language == "auto" else {"lang": page.language}
    )
    how = tr("Drag the new window to the projector and press F11.")
    keys = tr("By key or clicker, here and in that window:") if keyed else tr("By key or clicker, here:")
    more = tr("Page ↓: next. Page ↑: back. B: black screen. F: freeze.")
    return macros("features/lecture/screen.html").opener(urlencode(query), f"{how} {keys} {more}")
