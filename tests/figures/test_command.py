"""`lwr-duet figures`: which figures, where to, and how it says no."""

from pathlib import Path

import matplotlib
import pytest

from app.cli.figures import Figures, figures
from app.figures.figure_list import CATALOGUE, chosen
from controllers.errors import BadSetting


def test_numbers_and_names_in_any_order_once_and_all_unless_asked() -> None:
    for only, found in (("5,2", (2, 5)), (" hold, activation ,2", (2, 5)), ("", range(1, 9)), (" , ", range(1, 9))):
        assert [entry.number for entry in chosen(only) if entry.number] == list(found)
    assert chosen("") == chosen(" , ") == CATALOGUE
    assert [entry.name for entry in chosen("LAWS")] == ["laws"]


@pytest.mark.parametrize("only", ["9", "0", "two", "2;5", "-1"])
def test_no_such_figure(only: str) -> None:
    with pytest.raises(BadSetting) as refusal:
        chosen(f"2,{only}")
    message = str(refusal.value)
    assert repr(only) in message and "\n" not in message
    for entry in CATALOGUE:
        assert entry.name in message and (not entry.number or str(entry.number) in message)


def test_only_what_is_asked_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = dict(matplotlib.rcParams)
    out = tmp_path / "new" / "folder"
    assert figures(Figures(only="2", out=out, quick=True)) == 0
    assert {path.name for path in out.iterdir()} == {"report.md", *(f"fig2_activation.{kind}" for kind in ("csv", "png", "svg"))}
    assert str(out / "report.md") in capsys.readouterr().out
    assert dict(matplotlib.rcParams) == before
    assert "λ over the distance" in (out / "report.md").read_text(encoding="utf-8")


def test_same_drawing_each_time(tmp_path: Path) -> None:
    for name in ("a", "b"):
        assert figures(Figures(only="2,4", out=tmp_path / name, quick=True)) == 0
    for path in (tmp_path / "a").iterdir():
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes(), path.name


def test_a_folder_and_a_seed_that_cannot_be(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(BadSetting, match="another folder"):
        figures(Figures(only="2", out=tmp_path / "file" / "inside"))
    (tmp_path / "out" / "fig2_activation.png").mkdir(parents=True)
    with pytest.raises(BadSetting, match="cannot be written"):
        figures(Figures(only="2", out=tmp_path / "out"))
    for seed in (-1, 10_000):
        with pytest.raises(BadSetting, match="seed"):
            figures(Figures(only="2", out=tmp_path, seed=seed))
