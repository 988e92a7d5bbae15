"""Controls: visible if they matter, without effect if hidden; the picker changes the experiment."""

import re
from dataclasses import replace
from typing import Any
from unittest.mock import MagicMock

import pytest

from app.page.panels.curve_control import CurveControl
from app.session.relevant_settings import ALSO, matters
from app.session.session import Session
from app.settings import Settings
from scenes.experiments import EXPERIMENTS
from scenes.laws import LAWS
from scenes.settings import RunSettings, changed, specs, values
from scenes.simulation import Simulation
from tests.app.page.helpers import ON_PAGE, SPECS
from tests.app.page.helpers import another as other_value
from tests.scenes.helpers import moved, with_values

SCENES = tuple(EXPERIMENTS)

PATIENCE = 180.0
"""Longest time of a study on a busy machine [s]."""


def everything(scene: str, law: str, **others: Any) -> Settings:
    return with_values(Settings(), scene=scene, law=law, **others)


def another(key: str, present: Any) -> Any:
    """A valid value other than the present one; an extreme one for a number."""
    spec = SPECS[key]
    return spec.low if isinstance(present, float) and present != spec.low else other_value(key, present)[1]


def test_labels_are_short_and_all_hideable_keys_are_settings() -> None:
    assert set(ALSO) <= set(SPECS) and all(len(SPECS[key].label) <= 11 for key in ON_PAGE)


def moves(settings: RunSettings, steps: int = 120) -> bytes:
    simulation = moved(settings, lambda simulation: simulation.steps >= steps)
    return simulation.history.positions(simulation.history.table()).tobytes()


@pytest.mark.parametrize(
    ("scene", "law"),
    [
        *((scene, "smooth_priority") for scene in SCENES),
        *(("master_slave", law) for law in LAWS if law != "smooth_priority"),
    ],
)
def test_hidden_settings_do_not_change_a_bit_of_the_run(scene: str, law: str) -> None:
    settings = everything(scene, law, dm=0.28, d0=0.5)
    plain = moves(settings.run)
    hidden = [key for key in specs(RunSettings) if not matters(key, settings)]
    assert hidden
    for key in hidden:
        assert moves(changed(settings.run, key, another(key, values(settings)[key]))) == plain, key


@pytest.mark.thorough
@pytest.mark.parametrize("law", LAWS)
def test_every_number_that_a_law_shows_has_an_effect(law: str) -> None:
    settings = everything(
        "hold", law, dm=0.28, d0=0.5, n=2.0, guided="right", pairs="soft", beta=50.0, wmax=1.0
    )
    # A correction or a switch has no effect before it acts.
    steps = 1000 if LAWS[law].budget in ("correction", "switch") else 700
    plain = moves(settings.run, steps)
    for key in ("dm", "n", "v", "d0", "eta", "gamma", "kr", "pairs", "beta", "ff"):
        if matters(key, settings):
            assert moves(changed(settings.run, key, another(key, values(settings)[key])), steps) != plain, key


def test_only_two_arms_can_both_avoid() -> None:
    for scene in SCENES:
        run = replace(RunSettings(), scene=scene)
        assert run.both_avoid == (len(Simulation(run).roles.avoiders(run.avoid)) > 1)
        for avoid in ("free", "guided", "both"):
            chosen = replace(run, avoid=avoid)
            assert chosen.both_avoid == (len(Simulation(chosen).roles.avoiders(avoid)) > 1)


def test_a_law_and_an_experiment_show_their_settings() -> None:
    seen = lambda scene, law, **others: {  # noqa: E731
        key for key in SPECS if matters(key, everything(scene, law, **others))
    }
    assert all({"law", "k", "dt", "ghost", "theme"} <= seen("hold", law) for law in LAWS)
    of_scenes = ["path", "kx", "point", "ball", "following", "clip", "source", "avoid", "coupled", "law"]
    for scene, keys in {
        "solo": "path kx",
        "ball": "point ball law",
        "hold": "avoid law",
        "master_slave": "following avoid coupled law",
        "imitation": "clip source avoid coupled law",
    }.items():
        assert seen(scene, "smooth_priority") & {*of_scenes} == {*keys.split()}, scene
    assert "coupled" in seen("hold", "smooth_priority", avoid="both")
    assert "beta" not in seen("hold", "smooth_priority", pairs="single")
    assert "clip" not in seen("imitation", "smooth_priority", source="figure")


def text(html: str) -> str:
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", str(html)))


def test_a_bad_curve_text_is_dropped_once_another_curve_is_set_or_drawn() -> None:
    session = Session(everything("hold", "drawn_curve"))
    gui = MagicMock(add_html=lambda *_, **__: MagicMock(), add_text=lambda *_, **__: MagicMock(value=""))
    control = CurveControl(
        gui, session, "curve", "λ(d)", SPECS["curve"].help, values(session.settings)["curve"]
    )

    def says_something() -> bool:
        control.show(session.settings, True)
        return control.note.visible

    assert not says_something()
    control.take("no curve")
    assert says_something()
    session.change("curve", "0.1:1,0.3:0")
    assert not says_something() and control.box.value == "0.1:1,0.3:0"
    control.take("no curve")
    assert says_something()
    drawn = control.drawn
    control.draw(("law", "curve"), drawn)
    session.change("curve", control.known)
    assert not says_something()
    # An empty board does not change the law, and the note says so.
    control.draw(("law", "curve"), ())
    assert says_something() and "The last curve is used" in control.note.content
    control.draw(("law", "curve"), drawn)
    assert not says_something()
