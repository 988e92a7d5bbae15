"""The lessons on a page."""

from html import escape

from app.features.lessons.panel.answer_boxes import guess_words
from app.features.lessons.panel.elbow_marks import Marks
from app.features.lessons.panel.lesson_camera import lesson_view
from app.features.lessons.panel.lesson_panel import NARROW_WIDTH, WIDTH, LessonPanel
from app.features.lessons.session.lesson_session import LessonSession
from app.page.page_assets import style_sheet
from app.page.view import View
from app.session.frame import Frame
from app.settings import Profile
from app.stage.camera_view import view_of
from app.theme import scale
from scenes.rigs import Camera
from scenes.simulation import Simulation


class LessonView:
    """Panel, marks, camera and plots."""

    def __init__(self, view: View) -> None:
        self._view, self.lessons = view, view.session.parts.of(LessonSession)
        self._profile: Profile = view.page.profile
        book = None if view.language is None else self.lessons.english.in_language(view.language)
        sheet = lambda: style_sheet(view.page.profile)  # noqa: E731
        folds = view.folds and view.private
        self.panel = LessonPanel(
            view.host.gui, self.lessons, self._width, view.private, folds, view.narrow, sheet, book
        )
        self._marks = Marks(view.host.scene, self.lessons, lambda: view.page)
        self._step: tuple[object, ...] | None = None
        view.camera, view.keeps_back = self._seen, lambda: self.lessons.withholds
        view.card_attributes.append(lambda: guess_words(self.lessons, self.panel.guess_box))

    @property
    def _width(self) -> float:
        return (NARROW_WIDTH if self._view.narrow else WIDTH) * scale(self._profile)

    def _seen(self, simulation: Simulation) -> Camera:
        lessons = self.lessons
        return lesson_view(simulation, lessons.walk.step.camera) if lessons.open else view_of(simulation)

    def show(self, frame: Frame) -> None:
        lessons, view = self.lessons, self._view
        if self._profile != view.page.profile:
            self._profile = view.page.profile
            self.panel.set_width(self._width)
        self._marks.show(frame)
        step = (lessons.walk.lesson.id, lessons.walk.step.id) if lessons.open else None
        view.plots.only = lessons.walk.plots if lessons.open else ()
        if self.panel.show(frame) or step != self._step:
            self._step = step
            # The panel reduces the canvas.
            view.fit_again()
        contrast = self.panel.contrast
        names = self.panel.run_names if contrast is None else contrast.names
        view.plots.run_names = None if names is None else (escape(names[0]), escape(names[1]))
