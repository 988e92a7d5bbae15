"""Imports of the lessons: only `panel/` uses viser, only the commands use tyro."""

from tests.test_imports import ROOT, imported

LESSONS = ROOT / "app" / "features" / "lessons"


def test_only_the_panel_draws_and_only_the_commands_read_a_command_line() -> None:
    files = {
        path.relative_to(LESSONS).as_posix(): path.read_text(encoding="utf-8")
        for path in LESSONS.rglob("*.py")
    }
    users = {
        library: {
            file
            for file, source in files.items()
            if any(name.split(".")[0] == library for name in imported(source))
        }
        for library in ("viser", "tyro")
    }
    assert users["tyro"] == {"commands.py"}
    assert users["viser"] and all(file.startswith("panel/") for file in users["viser"])
