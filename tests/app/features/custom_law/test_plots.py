"""Plots of a run with a custom law."""

from pathlib import Path

from app.features.custom_law.custom_law import CustomLaw
from tests.app.plots.helpers import ShownPanel


def test_a_custom_law_has_no_resting_distance(tmp_path: Path) -> None:
    path = tmp_path / "my_law.py"
    path.write_text("def law(s):\n    return s.nominal", encoding="utf-8")
    shown = ShownPanel("hold")
    assert len(shown.show(0.5)[0].data[3]) and shown.says("d*")
    with CustomLaw(path) as law:
        shown.session.simulation.use(law)
        shown.session.reset()
        shown.show(0.5)
    assert not len(shown.gui.plots[0].data[3]) and not shown.says("d*")
