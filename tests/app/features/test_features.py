"""Features: one folder each, in one tuple; no file of the core imports them."""

from pathlib import Path

from app import features
from app.features import FEATURES
from tests.test_imports import ROOT, imported
from tests.test_rooms import arrows

FOLDER = Path(features.__file__).parent

COMPOSING = {"app/__main__.py", "app/lwr_duet/__init__.py"}
"""Entry points of programs, which import the tuple or the notebook's functions; nothing else imports them."""


def test_every_folder_is_in_the_tuple_and_has_a_readme() -> None:
    names = [feature.name for feature in FEATURES]
    assert sorted(names) == sorted(path.parent.name for path in FOLDER.glob("*/__init__.py"))
    assert [
        name
        for name in names
        if not (FOLDER / name / "README.md").read_text(encoding="utf-8").startswith("# ")
    ] == []


def test_no_file_of_the_core_imports_a_feature() -> None:
    of_features = {file for file in arrows() if file.startswith("app/features/")}
    assert len(of_features) > 50
    core = {file: targets for file, targets in arrows().items() if file not in of_features}
    assert {file for file, targets in core.items() if targets & of_features} == COMPOSING
    assert {file for file, targets in core.items() if targets & COMPOSING} == {"app/lwr_duet/__main__.py"}


def test_no_test_of_the_core_imports_a_feature() -> None:
    """Except the tuple of all features, which may be empty."""
    tests = (path for path in (ROOT / "tests").rglob("*.py") if not {"features", "tools"} & set(path.parts))
    found = {
        path.relative_to(ROOT).as_posix(): [
            name
            for name in imported(path.read_text(encoding="utf-8"))
            if name.startswith(("app.features.", "tests.app.features.")) and name != "app.features.FEATURES"
        ]
        for path in tests
    }
    assert {file: names for file, names in found.items() if names} == {}


def test_static_files_of_features_and_core_have_different_names() -> None:
    """Scripts, style sheets and templates."""
    core = {
        path.name for kind in ("js", "css", "html") for path in (ROOT / "app" / "page").rglob(f"*.{kind}")
    }
    own = {path.name for kind in ("js", "css", "html") for path in FOLDER.rglob(f"*.{kind}")}
    assert own and not own & core
