"""The page's scripts: what they are given reaches them safely, and a linter reads them."""

import platform
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from app.page.page_scripts import page_assets
from app.settings import PageSettings
from app.web.page_assets import PageAssets
from tests.test_imports import ROOT

BIOME = Path(sys.executable).with_name("biome")
PACKAGED = (sys.platform, platform.machine()) == ("linux", "x86_64")
"""Whether pyproject.toml asks for the linter here."""


@pytest.mark.skipif(not PACKAGED, reason="the linter of scripts is packaged for Linux on x86-64 only")
def test_scripts_and_style_sheets_are_free_of_faults(tmp_path: Path) -> None:
    def lint(folder: Path) -> tuple[int, str]:
        command = (str(BIOME), "ci", "--colors=off", "--error-on-warnings", "app")
        done = subprocess.run(command, capture_output=True, text=True, cwd=folder, timeout=60, check=False)
        return done.returncode, done.stdout + done.stderr

    code, said = lint(ROOT)
    assert code == 0, said
    count = sum(1 for kind in ("js", "css") for _ in (ROOT / "app").rglob(f"*.{kind}"))
    assert f"Checked {count} files" in said
    # With the same settings it finds faults.
    shutil.copy(ROOT / "biome.jsonc", tmp_path)
    (tmp_path / "app").mkdir()
    (tmp_path / "app" / "a.js").write_text(
        "duet.known = unknown;\n(() => {\n  const unused = 1;\n  var old = 1;\n  duet.known = old;\n})();\n"
    )
    (tmp_path / "app" / "a.css").write_text("a { colour: red; }\n")
    code, said = lint(tmp_path)
    rules = ("noUndeclaredVariables", "noUnusedVariables", "noVar", "noUnknownProperty")
    assert code != 0 and [rule for rule in rules if rule not in said] == [], said


def test_constants_cannot_end_the_script(tmp_path: Path) -> None:
    file = tmp_path / "one.js"
    file.write_text("run();", encoding="utf-8")
    made = (PageAssets((file,), constants={"a": 1}) + PageAssets(constants={"b": "</script><!--"})).script_html()
    assert made == '<script>"use strict";\nwindow.duet = {"a": 1, "b": "\\u003c/script>\\u003c!--"};\nrun();</script>'


def test_every_script_and_style_sheet_is_on_the_page() -> None:
    assets = page_assets(PageSettings())
    folder = ROOT / "app" / "page" / "static"
    assert {*folder.glob("*.js")} <= {*assets.scripts}
    # These two are sent in the page's panels, and change with its look.
    own = {path for path in assets.styles if path.parent == folder}
    assert {*folder.glob("*.css")} == {*own, folder / "style.css", folder / "replay.css"}
    assert len({*assets.scripts}) == len(assets.scripts)
