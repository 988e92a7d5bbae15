"""Custom law and editor of a server."""

from app.features.custom_law.command_options import CustomLawOptions
from app.features.custom_law.law_editor import FileText, LawEditor
from app.features.custom_law.law_limits import LawTimeShare
from app.features.custom_law.student_law import StudentLaw
from app.hosting.opened_feature import OpenedFeature
from app.page.panel_context import PanelContext
from app.session.late_law import LateLawMaker


class OpenedLaw(OpenedFeature):
    """A server's custom law.

    Raises:
        BadInputFile: the file does not exist.
    """

    def __init__(self, options: CustomLawOptions) -> None:
        path, self._edited = options.existing_file(), options.edited
        share = LawTimeShare()
        self.law: LateLawMaker | None = lambda background, wake: StudentLaw(path, share, background, wake)
        self.panels = (self._editor,)

    def _editor(self, page: PanelContext) -> LawEditor | None:
        # A law is a program: only the person who started the server writes one here.
        return (
            None
            if self._edited is None or not page.owners
            else LawEditor(page, FileText(page.session, self._edited))
        )
