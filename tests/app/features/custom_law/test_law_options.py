"""Options of a custom law on the command line: refusals, and their effect on a server and a run."""

import hashlib
from pathlib import Path

import pytest

from app.__main__ import run_command as main
from app.cli.main import main as command_line
from app.features.custom_law import CUSTOM_LAW
from app.features.custom_law.command_options import CustomLawOptions
from app.hosting.serve_options import ServeOptions
from app.runtime.terminal import INTERRUPTED
from app.start import App
from tests.app.cli.test_commands import assert_said, read, refused, run


@pytest.mark.parametrize(
    "option", ["--host 0.0.0.0", "--allow-origin https://b.org", "--embed-origin https://b.org"]
)
def test_only_the_owner_may_edit_a_law(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, option: str
) -> None:
    said = f"--edit-law is not possible with {option.partition(' https')[0]}|Leave out"
    assert_said(capsys, tmp_path, f"serve --edit-law {option}", said)


def test_a_missing_file_is_named(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert_said(capsys, tmp_path, "run --law-file {}/none.py --csv {}/hand.csv", "none.py")


def test_the_default_edited_file_is_in_the_current_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    served: list[ServeOptions] = []

    def start(options: ServeOptions, *_: object, **__: object) -> App:
        served.append(options)
        raise KeyboardInterrupt

    monkeypatch.setattr("app.start.start_app", start)
    assert command_line(["serve", "--edit-law"], (CUSTOM_LAW,)) == INTERRUPTED
    assert served[0].of(CustomLawOptions).edited == Path("my_law.py").absolute()


def test_the_template_is_the_papers_law_and_a_mistake_is_named_with_its_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = tmp_path / "my_law.py"
    assert main(["new-law", str(path)]) == 0
    capsys.readouterr()
    out = tmp_path / "out.csv"
    figures = [
        run(capsys, "--seconds", "8", *options)
        for options in ([], ["--law-file", str(path), "--csv", str(out)])
    ]
    top = read(out)[0]
    assert (top["law"], top["law_sha256"]) == ("my_law.py", hashlib.sha256(path.read_bytes()).hexdigest())
    for key in ("d_min", "e2_max"):
        assert figures[1][key] == pytest.approx(figures[0][key], rel=0.02), key
    text = path.read_text(encoding="utf-8")
    path.write_text(
        text.replace("def law(situation):\n", "def law(situation):\n    return 1 / 0\n"), encoding="utf-8"
    )
    line = refused(capsys, "run", "--seconds", "1", "--law-file", str(path))
    assert "ZeroDivisionError" in line and "my_law.py, line" in line
