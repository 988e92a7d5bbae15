"""A visitor's choice of the imitated person."""

from dataclasses import field

import viser

from app.features.person_files.bvh import from_bvh, read_bvh
from app.features.person_files.camera import CameraSource
from app.features.person_files.person_options import MODEL_REMEDY
from app.i18n.speaking import tr
from app.page.panel_context import PanelContext
from app.page.panels import PagePanel
from app.session.actions import Action
from app.session.frame import Frame
from app.session.parts import SessionPart
from app.settings import Source
from app.text.templates import element
from app.web.control_events import on_file
from controllers.errors import DuetError
from scenes.person.source import PersonTarget


class TakePerson(Action):
    name: str
    content: bytes = field(repr=False)


class UploadedPerson(SessionPart):
    """Survives a rebuilt page, but is not saved."""

    name = "uploaded_person"
    person: PersonTarget | None = None

    def saved(self) -> bytes:
        return b""

    def restore(self, saved: bytes) -> None:
        del saved


class SourceChooser(PagePanel):
    """Gives the session the chosen person. `bvh`, `camera`: of the server, or None."""

    def __init__(
        self, page: PanelContext, bvh: PersonTarget | None = None, camera: CameraSource | None = None
    ) -> None:
        self._session, self._bvh, self._camera = page.session, bvh, camera
        self._shown: Source | None = None
        gui, session = page.client.gui, page.session
        with page.controls.arms_tab:
            # viser shows an upload button even when it is not visible; hiding its folder hides it.
            self._folder = gui.add_folder(tr("Recorded motion"), visible=False)
            with self._folder:
                upload = gui.add_upload_button(
                    tr("Take in a BVH file"),
                    mime_type=".bvh",
                    icon=viser.Icon.UPLOAD,
                    color="gray",
                    hint=tr("A person's recorded motion; the names of most skeletons are understood."),
                )
            self._state = gui.add_html("", visible=False)
        on_file(upload, lambda name, content: session.post(TakePerson(name, content)))
        page.handlers.add(TakePerson, self._take_person)

    def _take_person(self, action: TakePerson) -> None:
        try:
            person = from_bvh(read_bvh(action.content, action.name))
        except DuetError as error:
            self._session.notify("This file cannot be imitated", str(error))
            return
        self._session.parts.of(UploadedPerson).person = person
        if self._shown == "file":
            self._say("")
            self._session.hand.set_source(person)

    def show(self, frame: Frame) -> None:
        settings = frame.live.settings
        source = settings.page.source if settings.run.experiment.moves == "person" else None
        if source != self._shown:
            before, self._shown = self._shown, source
            self._change(before, source)
        camera = self._camera
        if source == "camera" and camera is not None:
            self._say(tr(camera.message))

    def _change(self, before: Source | None, source: Source | None) -> None:
        self._folder.visible = source == "file"
        self._state.visible = source in ("file", "camera")
        if source == "file":
            person = self._session.parts.of(UploadedPerson).person or self._bvh
            self._say("" if person else tr("Choose a BVH file; until then the built-in clip continues."))
            self._session.hand.set_source(person)
        elif source == "camera":
            camera = self._camera
            if camera is None:
                self._say(
                    tr(
                        "No camera: start the server with --camera 0 (or --video FILE), and {remedy}.",
                        remedy=tr(MODEL_REMEDY),
                    )
                )
            self._session.hand.set_source(None if camera is None else PersonTarget(camera))
        elif (source == "clips" and before is not None) or (source is None and before in ("file", "camera")):
            self._session.hand.set_source(None)

    def _say(self, text: str) -> None:
        self._state.content = element("div", text, class_="duet duet-tip") if text else ""
