"""Scripts get constants safely and pass a linter; panels draw only from the frame."""

import ast
import platform
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from app.page.page_assets import page_assets
from app.settings import PageSettings
from app.web.pages import PageAssets
from tests.test_imports import ROOT

BIOME = Path(sys.executable).with_name("biome")
PACKAGED = (sys.platform, platform.machine()) == ("linux", "x86_64")
"""True if pyproject.toml requires the linter on this platform."""


@pytest.mark.skipif(not PACKAGED, reason="the linter of scripts is packaged for Linux on x86-64 only")
def test_scripts_and_style_sheets_pass_the_linter(tmp_path: Path) -> None:
    def lint(folder: Path) -> tuple[int, str]:
        command = (str(BIOME), "ci", "--colors=off", "--error-on-warnings", ".")
        done = subprocess.run(command, capture_output=True, text=True, cwd=folder, timeout=60, check=False)
        return done.returncode, done.stdout + done.stderr

    code, said = lint(ROOT / "app")
    assert code == 0, said
    # The linter also reads its own settings file.
    count = 1 + sum(1 for kind in ("js", "css") for _ in (ROOT / "app").rglob(f"*.{kind}"))
    assert f"Checked {count} files" in said
    # The same settings find faults in bad files.
    shutil.copy(ROOT / "app" / "biome.jsonc", tmp_path)
    (tmp_path / "a.js").write_text(
        "duet.known = unknown;\n(() => {\n  const unused = 1;\n  var old = 1;\n  duet.known = old;\n})();\n"
    )
    (tmp_path / "a.css").write_text("a { colour: red; }\n")
    code, said = lint(tmp_path)
    rules = ("noUndeclaredVariables", "noUnusedVariables", "noVar", "noUnknownProperty")
    assert code != 0 and [rule for rule in rules if rule not in said] == [], said


def test_constants_cannot_end_the_script(tmp_path: Path) -> None:
    file = tmp_path / "one.js"
    file.write_text("run();", encoding="utf-8")
    made = (
        PageAssets((file,), constants={"a": 1}) + PageAssets(constants={"b": "</script><!--"})
    ).script_html()
    assert (
        made
        == '<script>"use strict";\nwindow.duet = {"a": 1, "b": "\\u003c/script>\\u003c!--"};\nrun();</script>'
    )


def test_comments_are_not_sent_to_the_browser(tmp_path: Path) -> None:
    script, sheet = tmp_path / "one.js", tmp_path / "one.css"
    script.write_text("// What it does.\nrun();  // now\n  // More.\n\nstop();\n", encoding="utf-8")
    sheet.write_text("/* Of\n   two lines. */\na{color:red}\n", encoding="utf-8")
    made = PageAssets((script,), (sheet,))
    assert made.script_html() == '<script>"use strict";\nrun();  // now\n\nstop();\n</script>'
    assert made.style_html().endswith("}a{color:red}\n</style>")


def test_every_script_and_style_sheet_is_on_the_page() -> None:
    assets = page_assets(PageSettings())
    folder = ROOT / "app" / "page" / "static"
    assert {*folder.glob("*.js")} <= {*assets.scripts}
    # These three are sent in the page's panels, and change with the page's look.
    own = {path for path in assets.styles if path.parent == folder}
    assert {*folder.glob("*.css")} == {
        *own,
        folder / "style.css",
        folder / "replay.css",
        folder / "review.css",
    }
    assert len({*assets.scripts}) == len(assets.scripts)


PANELS = sorted((ROOT / "app" / "page" / "panels").glob("*.py"))

ALLOWED = {"post", "set_source", "parts", "law"}
"""Session attributes that drawing may use: writes, features, a law's process. The frame has the rest."""


def reads_past_the_frame(source: str) -> list[str]:
    """Session attributes, with lines, that a class's `show` and the methods it calls read."""
    found: list[str] = []
    for made in ast.walk(ast.parse(source)):
        if not isinstance(made, ast.ClassDef):
            continue
        methods = {node.name: node for node in made.body if isinstance(node, ast.FunctionDef)}
        waiting, seen = ["show"], set[str]()
        while waiting:
            name = waiting.pop()
            if name in seen or name not in methods:
                continue
            seen.add(name)
            for node in ast.walk(methods[name]):
                if not isinstance(node, ast.Attribute):
                    continue
                if isinstance(node.value, ast.Name) and node.value.id == "self":
                    waiting.append(node.attr)
                elif ast.unparse(node.value) in ("self._session", "session") and node.attr not in ALLOWED:
                    found.append(f"{node.lineno}: {ast.unparse(node)}")
    return found


@pytest.mark.parametrize("path", PANELS, ids=lambda path: path.name)
def test_a_panel_reads_only_the_frame(path: Path) -> None:
    assert reads_past_the_frame(path.read_text(encoding="utf-8")) == []


def test_a_read_past_the_frame_is_found_in_a_method_that_show_calls() -> None:
    source = "class Panel:\n    def show(self, frame):\n        self._draw()\n    def _draw(self):\n        print(self._session.held)\n"
    assert reads_past_the_frame(source) == ["5: self._session.held"]
