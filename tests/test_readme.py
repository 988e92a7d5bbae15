"""What the README says is true: its code runs, its keys and options exist."""

import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

from app.cli.main import COMMANDS
from app.page.panels.hotkeys import HOTKEYS
from app.settings import Settings, from_query

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    """Return the code blocks of one language."""
    return re.findall(rf"^```{language}\n(.*?)^```", README, flags=re.MULTILINE | re.DOTALL)


def test_python_block_runs() -> None:
    (code,) = blocks("python")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert float(done.stdout.split()[0]) > 0.1


def test_the_two_commands_come_first_and_are_self_contained() -> None:
    start, test = blocks("sh")[:2]
    for command in (start, test):
        assert command.count("\n") == 1
        assert command.startswith("python3 -m venv .venv && .venv/bin/pip install -q -c requirements.lock -e ")
    assert start.rstrip().endswith(".venv/bin/lwr-duet")
    assert test.rstrip().endswith(".venv/bin/python -m pytest")


@pytest.mark.parametrize("option", sorted(set(re.findall(r"(?<!\S)`?(--[a-z-]+)", README))))
def test_every_option_is_in_the_help_of_a_command(option: str) -> None:
    assert any(option in help_of(name) for name in COMMANDS)


@cache
def help_of(name: str) -> str:
    command = [sys.executable, "-m", "app", name, "--help"]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stdout


def test_the_link_in_the_readme_is_understood() -> None:
    query = re.findall(r"http://127\.0\.0\.1:8080/\?(\S+?)`", README)[0]
    settings, problems = from_query(dict(part.split("=") for part in query.split("&")), Settings())
    assert problems == ()
    assert settings.run.rig == "table" and settings.page.profile == "projector"


def test_every_key_is_in_the_table() -> None:
    table = README[README.index("| key | does |") : README.index("Try this")]
    for hotkey in HOTKEYS:
        assert hotkey.shown in table, hotkey
