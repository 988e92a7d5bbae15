"""Lesson cases of the core's `test_readout.py`."""

from app.features.measures.room_places import RoomPlace, Start, start_positions
from app.page.panels.distance_rate import promise_html
from app.text.lever_texts import lever_text
from controllers.laws.situation import FIRM_LEVER
from scenes.simulation import Simulation
from tests.app.page.test_readout import settings, text
from tests.approved import Approve


def test_a_short_row_shows_the_lever_with_its_value(approve: Approve) -> None:
    """A ball near the elbow, almost in the upper arm's direction."""
    simulation = Simulation(settings("scene=ball&point=elbow&v=0.05").run)
    simulation.reset(start_positions(simulation.room, Start(RoomPlace("elbow", "upper_arm", 0.1, 0.0872665))))
    simulation.step(None)
    sample = simulation.sample()
    assert sample.lever < FIRM_LEVER
    html = promise_html(simulation, sample)
    assert text(html).endswith(f"{lever_text(sample.lever)} (s = {sample.lever:.2f})")
    approve("promise.txt", f"{text(html)}\n")
    assert 'class="halt"' in html and 'class="alarm"' in html
