"""A further language needs one entry and its files: one is added to a copy of the app and used everywhere."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest

from app.__main__ import run_command as main
from app.features import FEATURES
from app.features.jupyter.duet import cell_html
from app.features.jupyter.notebook_run import NotebookRun
from app.features.lessons.loading import load_lessons
from app.hosting.serve_options import ServeOptions
from app.i18n.client_texts import translations
from app.i18n.reader_language import language_asked
from app.i18n.speaking import decimal, set_language
from app.start import start_app
from tests.blocking_client import BlockingClient

ROOT = Path(__file__).parents[3]
LAST_LANGUAGE = '"sl": "Slovenščina"'
CATALOGUE = r"""
"language" = "lingvo"
"Loading …" = "Ŝargado …"
"This Duet has ended. Run the cell again." = "Ĉi tiu Duet finiĝis."
"decimal sign\u0004." = ","
"""


def answers(folder: Path) -> dict[str, object]:
    """The app's texts in the new language, from every place with a choice of language."""
    opened = start_app(ServeOptions(), features=FEATURES)
    visitor = BlockingClient(opened.url, headers={"Accept-Language": "eo-XX, de;q=0.9"})
    visitor.wait_for(lambda v: any(e.get("label") == "lingvo" for e in list(v.mirror.gui.values())), 60.0)
    choice = visitor.mirror.labelled("lingvo")["options"]
    visitor.close()
    opened.close()
    set_language("eo")
    server = cast(NotebookRun, SimpleNamespace(key="k", port=1, server_run="r"))
    return {
        "page": list(choice),
        "number": decimal("0.5"),
        "asked": [language_asked({"lang": "eo"}, "de"), language_asked({}, "fr, eo;q=0.5, en;q=0.1")],
        "browser": translations()["eo"]["Loading …"],
        "notebook": "Ĉi tiu Duet finiĝis." in cell_html(server, 400),
        "lessons": [str(problem) for problem in load_lessons().problems],
        "handout": main(["handout", "--lesson", "1", "--lang", "eo", "--out", str(folder)]),
    }


@pytest.mark.thorough
def test_a_further_language_is_one_entry_a_catalogue_and_its_lessons(tmp_path: Path) -> None:
    app, out = tmp_path / "app", tmp_path / "out"
    # With Python's compiled files, which are valid while their sources are unchanged.
    shutil.copytree(ROOT / "app", app)
    settings = (app / "settings.py").read_text(encoding="utf-8")
    assert settings.count(LAST_LANGUAGE) == 1
    (app / "settings.py").write_text(
        settings.replace(LAST_LANGUAGE, f'{LAST_LANGUAGE}, "eo": "Esperanto"'), encoding="utf-8"
    )
    (app / "i18n" / "eo.toml").write_text(CATALOGUE, encoding="utf-8")
    lesson = (app / "features" / "lessons" / "files" / "01-redundancy.de.md").read_text(encoding="utf-8")
    translated = lesson.replace("# Redundanz und Nullraum", "# Redundo", 1)
    (app / "features" / "lessons" / "files" / "01-redundancy.eo.md").write_text(translated, encoding="utf-8")
    code = f"from tests.app.features.{Path(__file__).stem} import *; print(json.dumps(answers(Path({str(out)!r}))))"
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        timeout=300.0,
        check=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join((str(tmp_path), str(ROOT)))},
    )
    assert json.loads(done.stdout.splitlines()[-1]) == {
        "page": ["As the browser asks", "English", "Deutsch", "Slovenščina", "Esperanto"],
        "number": "0,5",
        "asked": ["eo", "eo"],
        "browser": "Ŝargado …",
        "notebook": True,
        "lessons": [],
        "handout": 0,
    }
    (page,) = out.iterdir()
    handout = page.read_text(encoding="utf-8")
    assert page.name.endswith("-eo.html") and '<html lang="eo">' in handout and "Redundo" in handout
