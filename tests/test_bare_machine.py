"""`.ci/run` runs the README's command on a bare machine; without one, it runs and reports it here."""

from pathlib import Path

import pytest

from tests.test_readme import README, ROOT, blocks
from tests.tools import bare_machine
from tests.tools.bare_machine import UNABLE, handed_on, installation, main, readme_commands


def test_the_commands_match_the_readme() -> None:
    commands = readme_commands(README)
    assert commands == [block.strip() for block in blocks("sh", README)]
    assert installation(commands[1]).startswith("python3 -m venv .venv && ") and installation(
        commands[1]
    ).endswith("-e '.[test]'")
    ci = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert "tests/tools/bare_machine.py --or-here --then " in ci
    # Not in the extra `test`; without them the peers' tests would be skipped.
    assert ci.index('pip install -q -c requirements.lock -e ".[test,peers]"') < ci.index("pytest -m thorough")


def test_only_the_settings_of_the_package_index_are_handed_on() -> None:
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
    """A computer without a bare machine, and a checkout with a README that only prints its installation."""
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
def test_without_a_bare_machine_the_command_runs_here_on_request(
    arguments: list[str], code: int, said: list[str], capfd: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == code
    out, error = capfd.readouterr()
    lines = out.splitlines()
    assert [line for line in lines if line in ("installed", "tested", "one", "two", "never")] == said
    assert "No bare machine here: it takes root on Linux." in error
