"""Controls: what matters is in view, what is hidden has no effect, and the picker changes the experiment."""

import re
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast, get_args

import pytest
import viser

from app.page.panels.compare import ComparePanel, smoothness_html, what_if_html
from app.page.panels.controls import PICKER
from app.session.frame import freeze
from app.session.relevant_settings import WHEN, both_avoid, matters
from app.session.session import Session
from app.session.studies import Smoothness, Studies
from app.settings import Settings
from scenes.headless import summarise
from scenes.rerun import WhatIf
from scenes.settings import LawName, RunSettings, SceneName, changed, specs, values
from scenes.simulation import Simulation
from scenes.smoothness import Measured
from tests.app.conftest import Arrive, OpenHouse
from tests.app.page.helpers import ON_PAGE, SPECS, page_label
from tests.app.page.helpers import another as other_value

SCENES: tuple[SceneName, ...] = get_args(SceneName)
LAWS: tuple[LawName, ...] = get_args(LawName)


def everything(scene: SceneName, law: LawName, **others: Any) -> Settings:
    settings = Settings()
    for key, value in {"scene": scene, "law": law, **others}.items():
        settings = changed(settings, key, value)
    return settings


def another(key: str, present: Any) -> Any:
    """A possible value other than the present one, an extreme one for a number."""
    spec = SPECS[key]
    return spec.low if isinstance(present, float) and present != spec.low else other_value(key, present)[1]


def test_a_label_is_short_and_what_may_be_hidden_is_a_setting() -> None:
    assert set(WHEN) <= set(SPECS) and all(len(SPECS[key].label) <= 11 for key in ON_PAGE)


def moves(settings: RunSettings, steps: int = 120) -> bytes:
    simulation = Simulation(settings)
    person = simulation.source()
    for _ in range(steps):
        simulation.step(person.target(simulation.time))
    return simulation.history.positions(simulation.history.table()).tobytes()


@pytest.mark.parametrize(
    ("scene", "law"),
    [*((scene, "smooth_priority") for scene in SCENES), *(("master_slave", law) for law in LAWS if law != "smooth_priority")],
)
def test_what_is_hidden_has_no_effect_to_the_last_bit(scene: SceneName, law: LawName) -> None:
    settings = everything(scene, law, dm=0.28, d0=0.5)
    plain = moves(settings.run)
    hidden = [key for key in specs(RunSettings) if not matters(key, settings)]
    assert hidden
    for key in hidden:
        assert moves(changed(settings.run, key, another(key, values(settings)[key]))) == plain, key


@pytest.mark.parametrize("law", LAWS)
def test_every_number_that_a_law_shows_has_an_effect(law: LawName) -> None:
    settings = everything("hold", law, dm=0.28, d0=0.5, n=2.0, guided="right", pairs="soft", beta=50.0, wmax=1.0)
    # A quadratic programme does nothing before it must.
    steps = 1000 if law in ("barrier_qp", "set_based_task") else 700
    plain = moves(settings.run, steps)
    for key in ("dm", "n", "v", "d0", "eta", "gamma", "kr", "pairs", "beta", "ff"):
        if matters(key, settings):
            assert moves(changed(settings.run, key, another(key, values(settings)[key])), steps) != plain, key


def test_only_two_arms_can_both_avoid() -> None:
    for scene in SCENES:
        run = replace(RunSettings(), scene=scene)
        assert both_avoid(run) == (len(Simulation(run).roles.avoiders(run.avoid)) > 1)
        for avoid in ("free", "guided", "both"):
            chosen = replace(run, avoid=avoid)
            assert both_avoid(chosen) == (len(Simulation(chosen).roles.avoiders(avoid)) > 1)


def test_which_settings_a_law_and_an_experiment_show() -> None:
    shown = lambda scene, law, **others: {key for key in SPECS if matters(key, everything(scene, law, **others))}  # noqa: E731
    for law in LAWS:
        keys = shown("hold", law)
        assert ("d0" in keys) == (law in ("potential_field", "null_space_avoidance", "task_activation"))
        assert ("eta" in keys) == (law == "potential_field") and ("gamma" in keys) == (law == "barrier_qp")
        assert ("kr" in keys) == (law == "set_based_task")
        assert ("n" in keys) == (law in ("smooth_priority", "intermediate_value", "continuous_inverse"))
        assert {"law", "k", "dt", "ghost", "theme"} <= keys
    of_scenes = ["path", "kx", "point", "ball", "following", "clip", "source", "avoid", "coupled", "law"]
    for scene, keys in {
        "solo": "path kx",
        "ball": "point ball law",
        "hold": "avoid law",
        "master_slave": "following avoid coupled law",
        "imitation": "clip source avoid coupled law",
    }.items():
        assert shown(scene, "smooth_priority") & {*of_scenes} == {*keys.split()}, scene
    assert "coupled" in shown("hold", "smooth_priority", avoid="both")
    assert "beta" not in shown("hold", "smooth_priority", pairs="single")
    assert "clip" not in shown("imitation", "smooth_priority", source="figure")


def test_the_picker_and_what_is_in_view(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house(), "autopilot=0")
    labelled, elements = one.visitor.mirror.labelled, list(one.visitor.mirror.gui.values())
    orders = [labelled(SPECS[key].label)["order"] for key in PICKER]
    assert orders == sorted(orders), "the picker stands above the numbers"
    assert all(element["order"] > orders[-1] for element in elements if 'class="duet duet-t' in str(element.get("content", "")))
    choices = "scene=master_slave law=potential_field scene=solo robot=ur5 scene=ball law=barrier_qp scene=imitation source=file"
    for key, value in (choice.split("=") for choice in f"{choices} scene=hold".split()):
        spec = SPECS[key]
        one.visitor.set_value(spec.label, spec.choice_labels[spec.choices.index(value)])
        one.wait(lambda s, key=key, value=value: values(s.settings)[key] == value)
        expected = {key for key in ON_PAGE if matters(key, one.session.settings)}
        # A hidden control keeps its place.
        one.visitor.wait_for(lambda _, expected=expected: {k for k in ON_PAGE if labelled(page_label(k))["visible"]} == expected)
        one.run_on(0.05)


def text(html: str) -> str:
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", html))


def test_smoothness_in_a_table() -> None:
    run = RunSettings()
    dts = (0.005, 0.0025, 0.00125, 0.000625)
    smooth = Measured(run, 10.0, dts, (0.08, 0.04, 0.02, 0.01))
    half = Measured(run, 10.0, dts, (0.5, None, 0.51, None))
    html = text(smoothness_html(Smoothness(smooth, half)))
    assert "5 ms 0.0800 0.5000" in html and "2.5 ms 0.0400 …" in html and "0.625 ms 0.0100 …" in html
    assert f"Law: {smooth.words}" in html and f"Ghost: {half.words}" in html
    assert "Ghost" not in text(smoothness_html(Smoothness(smooth, None)))


def test_the_panel_follows_the_studies(monkeypatch: pytest.MonkeyPatch) -> None:
    session = Session(Settings())
    gui = _Gui()
    panel = ComparePanel(cast(viser.GuiApi, gui), session)
    answers: dict[str, Any] = {"what_if": None, "smoothness": None, "busy": False, "message": ""}
    for name in answers:
        monkeypatch.setattr(Studies, name, property(lambda _, name=name: answers[name], lambda *_: None), raising=False)

    def seen() -> str:
        panel.show(freeze(session, 0.0))
        before = [block.written for block in gui.blocks]
        panel.show(freeze(session, 0.0))
        assert [block.written for block in gui.blocks] == before
        return text(" ".join(block.content for block in gui.blocks))

    assert seen().strip() == ""
    session.change("whatif", True)
    assert "Now move" in seen()
    answers["busy"] = True
    assert "Computing" in seen()
    answers["busy"] = False
    for length in (40, 30):
        answers["what_if"] = answer_of("hold", length)
        assert "as it was" in seen()
    answers["message"], answers["what_if"] = "Too many computations are waiting; ask again in a moment.", None
    assert "Too many computations" in seen()
    run = RunSettings()
    for largest in ((None, None, None, None), (0.2, None, None, 0.1), (0.2, 0.1, 0.05, 0.025)):
        answers["smoothness"] = Smoothness(Measured(run, 10.0, (0.02, 0.01, 0.005, 0.0025), largest), None)
        assert ("Measuring" in seen()) == (None in largest)
    session.change("scene", "solo")
    panel.show(freeze(session, 0.0))
    assert not any(block.visible for block in gui.blocks) and not gui.group.visible


class _Block(SimpleNamespace):
    written = 0

    def __setattr__(self, name: str, value: object) -> None:
        super().__setattr__(name, value)
        if name == "content":
            self.written += 1


class _Gui:
    def __init__(self) -> None:
        self.blocks: list[_Block] = []
        self.group = SimpleNamespace(visible=True, on_click=lambda callback: callback)

    def add_html(self, content: str) -> _Block:
        self.blocks.append(_Block(content=content, visible=True))
        return self.blocks[-1]

    def add_button_group(self, *_: object, **__: object) -> SimpleNamespace:
        return self.group


def answer_of(scene: SceneName, steps: int) -> WhatIf:
    """What if a run at rest had been at rest."""
    simulation = Simulation(RunSettings(scene=scene))
    for _ in range(steps):
        simulation.step(None)
    table = simulation.history.table()
    summary = summarise(simulation, table)
    return WhatIf(table[:, 0], table[:, 1], table[:, 3], simulation.settings, summary, summary, 1)


@pytest.mark.parametrize("scene", ["hold", "master_slave"])
def test_what_if_in_a_table(scene: SceneName) -> None:
    answer = answer_of(scene, 40)
    before = answer.before
    answer = replace(answer, summary=replace(before, d_min=0.1234, share_below=0.25, e2_max=0.01, dq_step_max=0.5))
    html = text(what_if_html(answer))
    assert f"{1000.0 * before.d_min:.0f} mm 123 mm" in html and "25 %" in html and "0.500 rad/s" in html
    assert ("5.7°" in html) == (scene == "master_slave") and ("100 mm" in html) == (scene == "hold")
    assert "draft" not in html and "draft" in text(what_if_html(replace(answer, stride=2)))
