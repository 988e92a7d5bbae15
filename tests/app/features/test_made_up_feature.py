"""A feature is a folder and a tuple entry: a made-up one is added to a copy, found there, and removed."""

import sys
import textwrap
from pathlib import Path

import pytest

from tests.app.features.test_without import do, left_without

pytestmark = pytest.mark.thorough

FILES = {
    "app/features/made_up/__init__.py": '''
        """Halves the critical distance, and counts how often."""

        from collections.abc import Mapping, Sequence
        from pathlib import Path
        from typing import Final

        from app.feature import Command, Feature


        def _commands() -> Mapping[str, Command]:
            from app.features.made_up.command import Halved, print_half

            return {"halved": Command(Halved, print_half, "compute")}


        def _panels():
            from app.features.made_up.panel import HalvePanel

            return (HalvePanel,)


        MADE_UP: Final = Feature("made_up", texts=Path(__file__).parent, commands=_commands, panels=_panels)
        ''',
    "app/features/made_up/de.toml": '"halve it" = "halbiere ihn"',
    "app/features/made_up/command.py": '''
        from dataclasses import dataclass


        @dataclass(frozen=True)
        class Halved:
            """Print the half of a distance."""

            distance: float = 0.2
            """In metres."""


        def print_half(command: Halved) -> int:
            print(command.distance / 2.0)
            return 0
        ''',
    "app/features/made_up/panel.py": '''
        from app.i18n.speaking import tr
        from app.page.panel_context import PanelContext
        from app.page.panels import PagePanel
        from app.session.actions import Action
        from app.session.frame import Frame
        from app.session.parts import SessionPart
        from app.session.session import Session


        class Halve(Action, newest_by=None):
            """Halve the critical distance."""


        class Halvings(SessionPart):
            name = "halvings"

            def __init__(self, session: Session) -> None:
                super().__init__(session)
                self.count = 0

            def saved(self) -> bytes:
                return b"%d" % self.count

            def restore(self, saved: bytes) -> None:
                self.count = int(saved)


        class HalvePanel(PagePanel):
            def __init__(self, page: PanelContext) -> None:
                self._session = page.session
                page.client.gui.add_button(tr("halve it")).on_click(lambda _: page.session.post(Halve()))
                self._text = page.client.gui.add_text("made up", "")
                page.handlers.add(Halve, self._halve)

            def _halve(self, action: Halve) -> None:
                session = self._session
                session.parts.of(Halvings).count += 1
                session.change("dm", 0.5 * session.settings.run.law.critical_distance)

            def show(self, frame: Frame) -> None:
                count = self._session.parts.of(Halvings).count
                self._text.value = f"{count}: {1000.0 * frame.settings.run.law.critical_distance:.0f} mm"
        ''',
}

VISIT = """
import sys
from pathlib import Path
from app.features import FEATURES
from app.features.store.store_options import StoreOptions
from app.hosting.serve_options import ServeOptions
from app.start import start_app
from tests.blocking_client import BlockingClient

def visit(click, says):
    app = start_app(ServeOptions(sessions=2, features=(StoreOptions(file=Path(sys.argv[1])),)), features=FEATURES)
    try:
        with BlockingClient(app.url, query="dm=0.2&lang=de&resume=" + "7" * 32) as visitor:
            visitor.wait_for(lambda v: "halbiere ihn" in str(v.mirror.gui), 120.0)
            if click:
                visitor.click("halbiere ihn")
            visitor.wait_for(lambda v: v.mirror.labelled("made up")["value"] == says, 120.0)
    finally:
        app.close()

visit(True, "1: 100 mm")
visit(False, "1: 100 mm")
print("it is there")
"""


def test_a_made_up_feature_is_a_folder_and_an_entry_in_the_tuple(tmp_path: Path) -> None:
    left_without(tmp_path, set())
    listed = tmp_path / "app" / "features" / "__init__.py"
    before = listed.read_text(encoding="utf-8")
    for name, text in FILES.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(textwrap.dedent(text), encoding="utf-8")
    first = "FEATURES: Final[tuple[Feature, ...]] = (\n"
    assert first in before
    added = "from app.features.made_up import MADE_UP\n"
    listed.write_text(added + before.replace(first, f"{first}    MADE_UP,\n"), encoding="utf-8")
    assert " halved " in do(tmp_path, sys.executable, "-m", "app", "--help")
    assert do(tmp_path, sys.executable, "-m", "app", "halved", "--distance", "0.3") == "0.15\n"
    assert do(tmp_path, sys.executable, "-c", VISIT, str(tmp_path / "store")) == "it is there\n"
    # After its removal everything is unchanged, also for the visitor with its part in a record.
    left_without(tmp_path, {"made_up"})
    assert listed.read_text(encoding="utf-8") == before
    assert " halved " not in do(tmp_path, sys.executable, "-m", "app", "--help")
    assert "d_min" in do(tmp_path, sys.executable, "-m", "app", "run", "--seconds", "0.1")
