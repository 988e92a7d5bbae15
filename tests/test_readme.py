"""The README and the documents are true: their code runs, their keys, options and links exist."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from app.__main__ import run_command as main
from app.cli.main import commands_with
from app.features import FEATURES
from app.page.panels.hotkeys import hotkeys
from app.settings import Settings, from_query

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
FILES = {
    path.name: path
    for path in (
        *(ROOT / "app" / "documents").glob("*.md"),
        *(one.file for f in FEATURES for one in f.documents.values()),
    )
}
DOCUMENTS = {name: path.read_text(encoding="utf-8") for name, path in FILES.items()}
TEXTS = README + "".join(DOCUMENTS.values())
OURS = re.sub(
    r"^(?:dask|docker|echo|podman|sudo) (?:.*\\\n)*.*$|`(?:docker|wsl) [^`]*`", "", TEXTS, flags=re.MULTILINE
)
"""The texts without commands of other programs."""


def blocks(language: str, text: str) -> list[str]:
    """Code blocks of one language."""
    return re.findall(rf"^```{language}\n(.*?)^```", text, flags=re.MULTILINE | re.DOTALL)


@pytest.mark.slow
def test_every_example_runs_alone_and_prints_numbers() -> None:
    examples = blocks("python", TEXTS)
    assert len(examples) >= 6
    # In one process, which loads the libraries once; every example begins with an empty namespace.
    code = f"for code in {examples!r}:\n    print('example')\n    exec(compile(code, 'example', 'exec'), {{'__name__': 'example'}})"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=240, check=False
    )
    assert done.returncode == 0, done.stderr
    _, *printed = done.stdout.split("example\n")
    assert [text for text in printed if not re.search(r"\d\.\d|\d\d", text)] == []
    assert len(printed) == len(examples)


def test_the_two_commands_come_first_and_are_self_contained() -> None:
    start, test = blocks("sh", README)
    for command in (start, test):
        assert command.count("\n") == 1
        assert command.startswith(
            "python3 -m venv .venv && .venv/bin/pip install -q -c requirements.lock -e "
        )
    assert start.rstrip().endswith(".venv/bin/lwr-duet")
    assert test.rstrip().endswith(".venv/bin/python -m pytest")


def test_every_option_is_in_the_help_of_a_command(capsys: pytest.CaptureFixture[str]) -> None:
    for name in commands_with(FEATURES):
        for option in ("--help", "--help-all"):
            with pytest.raises(SystemExit, match="0"):
                main([name, option])
    told, named = capsys.readouterr().out, set(re.findall(r"(?<!\S)`?(--[a-z-]+)", OURS))
    assert len(named) > 50 and [option for option in sorted(named) if option not in told] == []


@pytest.mark.parametrize("name", ["README.md", *DOCUMENTS])
def test_every_link_and_picture_has_a_file(name: str) -> None:
    folder, text = (ROOT, README) if name == "README.md" else (FILES[name].parent, DOCUMENTS[name])
    links = [link for link in re.findall(r"\]\(([^)\s]+)\)", text) if not link.startswith("https://")]
    assert [link for link in links if not (folder / link).is_file()] == []


def test_the_link_in_the_documents_is_valid() -> None:
    query = re.findall(r"http://127\.0\.0\.1:8080/\?(\S+?)`", TEXTS)[0]
    settings, problems = from_query(dict(part.split("=") for part in query.split("&")), Settings())
    assert problems == ()
    assert settings.run.rig == "table" and settings.page.profile == "projector"


def test_every_key_is_in_the_table() -> None:
    text = DOCUMENTS["page.md"]
    table = text[text.index("| key | does |") : text.index("## The experiments")]
    for hotkey in hotkeys():
        assert hotkey.shown in table, hotkey


def test_every_file_that_a_recipe_or_a_teacher_s_note_names_exists() -> None:
    lessons = ROOT / "app" / "features" / "lessons" / "files"
    of_lessons = "".join(
        path.read_text(encoding="utf-8") for path in (lessons / "README.md", *lessons.glob("*.notes.md"))
    )
    named = {
        path
        for path in re.findall(r"`((?:app|scenes|controllers|tests)/[\w/.-]+)`", DOCUMENTS["recipes.md"])
        if "<" not in path
    } | set(re.findall(r"`([\w/]+\.py)`", of_lessons))
    assert "app/features/custom_law/trials.py" in named
    assert len(named) >= 15 and [path for path in sorted(named) if not (ROOT / path).exists()] == []
