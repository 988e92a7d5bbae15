"""What `.ci/run` runs on a bare machine is the README's command; where there can be none, it is run here, and that is said."""

from pathlib import Path

import pytest

from tests.test_readme import README, ROOT, blocks
from tests.tools import bare_machine
from tests.tools.bare_machine import UNABLE, handed_on, installation, main, readme_commands


def test_the_commands_are_those_of_the_readme() -> None:
    commands = readme_commands(README)
    assert commands == [block.strip() for block in blocks("sh", README)]
    assert installation(commands[1]).startswith("python3 -m venv .venv && ") and installation(
        commands[1]
    ).endswith("-e '.[test]'")
    ci = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert "tests/tools/bare_machine.py --or-here --then " in ci
    # Not a part of the extra `test`; without them their tests would be skipped.
    assert ci.index('pip install -q -c requirements.lock -e ".[test,peers]"') < ci.index("pytest -m thorough")


def test_of_this_computer_only_the_way_to_the_package_index_is_handed_on() -> None:
    ours = {
        "PYTHONPATH": "x",
        "DUET_BROWSER": "x",
        "PIP_FIND_LINKS": "/wheels",
        "LANG": "sl_SI",
        "HOME": "/home/ann",
    }
    index = {
        "PIP_INDEX_URL": "https://example.org/simple",
        "https_proxy": "http://proxy:3128",
        "NO_PROXY": "localhost",
    }
    assert handed_on(ours | index) == index


@pytest.fixture
def nowhere(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """No bare machine can be had, and a checkout whose README only says that it is installed."""
    (tmp_path / "README.md").write_text(
        "```sh\ntrue\n```\n\n```sh\necho installed && echo tested\n```\n", encoding="utf-8"
    )
    monkeypatch.setattr(bare_machine, "ROOT", tmp_path)
    monkeypatch.setattr(bare_machine, "reason_against", lambda: "it takes root on Linux")


@pytest.mark.usefixtures("nowhere")
@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        ([], UNABLE, []),
        (["--or-here"], 0, ["installed", "tested"]),
        (["--or-here", "exit 7"], 7, ["installed"]),
        (["--or-here", "--then", "echo one\nfalse\necho two"], 1, ["installed", "tested", "one"]),
        (["--or-here", "false", "--then", "echo never"], 1, ["installed"]),
    ],
)
def test_where_there_can_be_none_the_command_runs_here_if_asked_for(
    arguments: list[str], code: int, said: list[str], capfd: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == code
    out, error = capfd.readouterr()
    lines = out.splitlines()
    assert [line for line in lines if line in ("installed", "tested", "one", "two", "never")] == said
    assert "No bare machine here: it takes root on Linux." in error
