"""`lwr-duet figures`: which figures, where to, and how it says no."""

from pathlib import Path

import matplotlib
import pytest

from app.cli.figures import Figures, figures
from app.figures.figure_list import CATALOGUE, chosen
from controllers.errors import BadSetting


def names(only: str) -> list[str]:
    """The figures that are chosen."""
    return [entry.name for entry in chosen(only)]


def test_all_unless_asked() -> None:
    assert names("") == names(" , ") == [entry.name for entry in CATALOGUE]
    assert [entry.number for entry in CATALOGUE if entry.number] == [1, 2, 3, 4, 5, 6, 7, 8]


def test_numbers_and_names_in_any_order_once() -> None:
    assert names("5,2") == names(" hold, activation ,2") == ["activation", "hold"]
    assert names("LAWS") == ["laws"]


@pytest.mark.parametrize("only", ["9", "0", "two", "2;5", "-1"])
def test_no_such_figure(only: str) -> None:
    with pytest.raises(BadSetting) as refusal:
        chosen(f"2,{only}")
    message = str(refusal.value)
    assert repr(only) in message and "\n" not in message
    for entry in CATALOGUE:
        assert entry.name in message and (not entry.number or str(entry.number) in message)


def test_only_what_is_asked_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In a folder that is made; the style is left as it was."""
    before = dict(matplotlib.rcParams)
    out = tmp_path / "new" / "folder"
    assert figures(Figures(only="2", out=out, quick=True)) == 0
    assert sorted(path.name for path in out.iterdir()) == [
        "fig2_activation.csv",
        "fig2_activation.png",
        "fig2_activation.svg",
        "report.md",
    ]
    assert str(out / "report.md") in capsys.readouterr().out
    assert dict(matplotlib.rcParams) == before
    assert "λ over the distance" in (out / "report.md").read_text(encoding="utf-8")


def test_same_drawing_each_time(tmp_path: Path) -> None:
    """SVG and PNG too, on the same machine."""
    for name in ("a", "b"):
        assert figures(Figures(only="2,4", out=tmp_path / name, quick=True)) == 0
    for path in (tmp_path / "a").iterdir():
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes(), path.name


def test_a_folder_that_cannot_be(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(BadSetting, match="another folder"):
        figures(Figures(only="2", out=tmp_path / "file" / "inside"))
    (tmp_path / "out" / "fig2_activation.png").mkdir(parents=True)
    with pytest.raises(BadSetting, match="cannot be written"):
        figures(Figures(only="2", out=tmp_path / "out"))


@pytest.mark.parametrize("seed", [-1, 10_000])
def test_a_seed_out_of_range(seed: int, tmp_path: Path) -> None:
    with pytest.raises(BadSetting, match="seed"):
        figures(Figures(only="2", out=tmp_path, seed=seed))
