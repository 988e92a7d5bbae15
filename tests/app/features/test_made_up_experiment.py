"""An experiment is declared once: a made-up entry in the register works everywhere."""

import html
import re
import sys
from collections.abc import Iterator
from contextlib import redirect_stdout
from dataclasses import replace
from io import StringIO
from pathlib import Path

import numpy as np
import pytest

from app.__main__ import run_command as main
from app.features.exports.csv_table import csv_bytes
from app.features.exports.player import player_html
from app.features.exports.plot_pictures import picture_bytes
from app.features.exports.python_snippet import as_python
from app.features.lessons.panel.lesson_keys import key_help
from app.features.lessons.scripts import SCRIPTS
from app.features.sweep.heatmaps import HeatmapPlan
from app.page.panels import contact_card
from app.page.panels.hotkeys import help_html, hotkeys
from app.page.panels.readout import status_html, tip_text
from app.plots.plot_choice import cells, possible_details, possible_plots
from app.session.frame import freeze
from app.session.relevant_settings import matters
from app.session.session import Session
from app.settings import PageSettings, Settings, from_query, to_query
from app.text.experiment_texts import EXPERIMENT_TEXTS, ExperimentTexts
from scenes.arm_tasks.hold_task import HoldTask
from scenes.ball import BallInTheWay, BallTask
from scenes.experiments import EXPERIMENTS, Experiment
from scenes.headless import run
from scenes.history import COLUMN
from scenes.roles import NO_TARGETS, Roles, Scripted
from scenes.room import World
from scenes.settings import RunSettings, specs
from scenes.simulation import Simulation
from scenes.sweep import FIGURES, Axis, Grid
from scenes.targets import BallTarget
from tests.app.cli.test_commands import read
from tests.app.conftest import ELBOW, HAND, Arrive, OpenHouse
from tests.app.page.helpers import page_label, press, shown
from tests.scenes.helpers import recorded_run
from tests.test_imports import ROOT

NAME, LABEL, SHORT = "made_up", "Made up, for a test", "made up"
TIP, WATCHED = "Push the ball at the hand that stays.", "The hand stays where it is."


class MadeUp(BallInTheWay):
    """A hand that holds its place while the visitor moves the ball."""

    def roles(self, world: World, settings: RunSettings) -> Roles:
        arm = world.room.arms[0]
        keeper = HoldTask(world, arm)
        return Roles((BallTask(world), keeper), arm, arm, keeper, None, (keeper,))

    def source(self, world: World, settings: RunSettings) -> Scripted:
        return NO_TARGETS

    def way(self, settings: RunSettings, home: np.ndarray) -> np.ndarray:
        return np.zeros((0, 3))


ENTRY = Experiment(
    NAME, LABEL, SHORT, f"{NAME}:MadeUp", "ball", "ball", "nothing", ("robot", "task", "point")
)
TEXTS = ExperimentTexts(TIP, WATCHED)


@pytest.fixture(autouse=True)
def made_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """The made-up experiment in the register during a test; the product is otherwise unchanged."""
    monkeypatch.setitem(sys.modules, f"scenes.{NAME}", sys.modules[__name__])
    monkeypatch.setitem(EXPERIMENTS, NAME, ENTRY)
    monkeypatch.setitem(EXPERIMENT_TEXTS, NAME, lambda run, itself: TEXTS)


def pushed() -> tuple[Simulation, Settings]:
    """The experiment with the ball so close that the arm gives way, and its settings."""
    simulation = Simulation(RunSettings(scene=NAME))
    hand = simulation.kinematics.hand_pose(simulation.avoiding).translation.copy()
    while simulation.sample().activation <= 0.05:
        simulation.step(BallTarget(hand))
    return simulation, Settings(simulation.settings)


def test_the_command_line_runs_it_and_writes_its_table(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert (
        main(
            ["run", "--scene", NAME, "--point", "arm", "--seconds", "0.5", "--csv", str(tmp_path / "run.csv")]
        )
        == 0
    )
    about, _, rows = read(tmp_path / "run.csv")
    assert about["scene"] == NAME and "e2 [m²]" in about["units"]
    twin = run(RunSettings(scene=NAME, point="arm"), 0.5)
    assert [float(row["d"]) for row in rows] == pytest.approx(twin.table[:, COLUMN["d"]].tolist(), abs=1e-9)
    assert {"ball_q_x", "arm_q1"} <= set(rows[0])
    assert main(["run", "--scene", "made_upp"]) == 2
    assert f"{NAME}." in capsys.readouterr().err


def test_a_link_opens_it_with_its_settings() -> None:
    settings, problems = from_query({"scene": NAME, "point": "elbow"}, Settings())
    assert not problems and settings.run == RunSettings(scene=NAME, point="elbow")
    assert from_query(to_query(settings), Settings())[0] == settings
    assert to_query(settings)["scene"] == NAME


def test_only_the_settings_that_the_experiment_reads_matter() -> None:
    of = Settings(RunSettings(scene=NAME))
    usual = {
        key
        for key in specs(RunSettings)
        if matters(key, replace(of, run=replace(of.run, scene="ball", ball="cross")))
    }
    assert {key for key in specs(RunSettings) if matters(key, of)} == usual - {"ball"}
    assert not {"rig", "guided", "avoid", "path", "kx", "clip", "following", "start", "coupled"} & usual


def test_card_readout_and_tip_are_as_for_a_ball() -> None:
    simulation, settings = pushed()
    session = Session(settings)
    frame = replace(freeze(session, 0.0), simulation=simulation, sample=simulation.sample())
    words = contact_card.contact_words(frame, [])
    assert words["obstacle"] == ("orange", "ball") and words["two"] is False
    assert words["bodies"]["w"] == ["/ball"] and words["bodies"]["v"] == ["/arms/arm"]  # type: ignore[index]
    assert tip_text(frame.shown) == TIP and tip_text(frame.shown, operated=False) == WATCHED
    fast = replace(simulation.sample(), law_approach=1.0, distance=-0.01)
    said = status_html(frame.pace, simulation, fast)
    assert "the ball is faster than v" in said and "the arm overlaps the ball" in said
    table = help_html(further=key_help())
    assert f"<kbd>7</kbd></td><td>{SHORT}</td>" in table and "<kbd>1</kbd> … <kbd>7</kbd>" in table


def test_its_plots_are_as_for_an_arm_with_an_obstacle() -> None:
    alike = RunSettings(scene="ball")
    assert possible_details(RunSettings(scene=NAME)) == possible_details(alike)
    assert possible_plots(RunSettings(scene=NAME)) == possible_plots(alike)
    assert cells(RunSettings(scene=NAME), "lambda") == ("distance", "error", "lambda")
    assert {name for name, one in SCRIPTS.items() if one.fits(NAME)} == {
        "ball_to",
        "ball_push",
        "ball_circle",
    }


def test_a_visitor_opens_it_and_pulls_its_ball(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house(), "gizmo=1&autopilot=0&speed=2")
    chooser = one.visitor.mirror.labelled(page_label("scene"))
    assert chooser["options"][-1] == LABEL and len(chooser["options"]) == len(EXPERIMENTS)
    assert [hotkey.key for hotkey in hotkeys() if hotkey.name == NAME] == ["7"]
    press(one, NAME)
    one.wait(lambda s: s.settings.run.scene == NAME and s.simulation.room.ball is not None)
    of_page = lambda key: one.visitor.mirror.labelled(page_label(key))["visible"]  # noqa: E731
    one.visitor.wait_for(lambda _: of_page("point") and of_page("law"))
    one.visitor.wait_for(lambda _: not any(of_page(key) for key in ("ball", "guided", "path", "clip")))
    one.visitor.wait_for(lambda v: TIP in shown(v))
    others = {HAND, ELBOW, "/path/line", "/person/body"}
    one.visitor.wait_for(
        lambda v: {"/ball", "/gizmo/ball"} <= set(v.mirror.nodes) and not others & set(v.mirror.nodes)
    )
    goal = one.ask(lambda s: s.simulation.positions[s.simulation.room.ball] + np.array([0.0, 0.0, 0.06]))
    one.visitor.move_gizmo("/gizmo/ball", phase="start")
    one.visitor.move_gizmo("/gizmo/ball", tuple(goal.tolist()))
    one.wait(lambda s: isinstance(s.held, BallTarget))
    one.visitor.wait_for(
        lambda v: np.linalg.norm(np.array(v.mirror.nodes["/ball"]["position"]) - goal) < 0.02
    )
    one.visitor.move_gizmo("/gizmo/ball", phase="end")
    one.wait(lambda s: s.held is None)
    one.visitor.set_value(page_label("scene"), specs()["scene"].options()["hold"])
    one.wait(lambda s: s.settings.run.scene == "hold")


def test_exports_and_the_player_name_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _, recorded = recorded_run(RunSettings(scene=NAME), 0.5, 99.0, {})
    assert f"scene={NAME}" in csv_bytes(recorded, 0.5).decode().replace(" ", "").replace(":", "=")
    assert LABEL in player_html(recorded, 0.5, PageSettings(details="laws")).decode()
    assert LABEL in picture_bytes(recorded, 0.5, "lambda", "svg").decode()
    snippet = as_python(recorded, recorded, 0.5, "mine")
    assert f"scene='{NAME}'" in snippet.text and "e² [m²]" in snippet.text and "$d_m$" in snippet.text
    monkeypatch.chdir(tmp_path)
    with redirect_stdout(StringIO()) as said:
        exec(compile(snippet.text, "snippet", "exec"), {})
    assert "Summary(d_min=" in said.getvalue() and (tmp_path / "mine.png").is_file()


def test_a_sweep_over_it_has_the_unit_of_its_error() -> None:
    grid = Grid(RunSettings(scene=NAME), (Axis("dm", (0.1, 0.15)),), 0.1)
    table = HeatmapPlan(grid, {index: (0.1,) * len(FIGURES) for index in range(2)})
    assert table.named("e2_max").endswith("[m²]")


LESSON = f"""# Made up

A lesson in an experiment that no file of the product names.

```duet
settings = {{ scene = "{NAME}", point = "hand" }}
```

## The ball comes

```duet
id = "comes"
input = {{ script = "ball_push", speed = 0.2 }}
seconds = 1.0
plots = ["distance", "error"]
```

### Goal

See what the hand does.

### Do

Watch.
"""


def test_a_lesson_in_it_is_printed(tmp_path: Path) -> None:
    folder = tmp_path / "lessons"
    folder.mkdir()
    (folder / "01-made-up.md").write_text(LESSON, encoding="utf-8")
    with redirect_stdout(StringIO()) as said:
        assert main(["handout", "--folder", str(folder), "--out", str(tmp_path / "out")]) == 0
    page = Path(said.getvalue().strip()).read_text("utf-8")
    assert "The ball comes" in html.unescape(page)


def sources() -> Iterator[tuple[str, str]]:
    for floor in ("app", "scenes", "controllers"):
        for path in (ROOT / floor).rglob("*"):
            if path.suffix in (".py", ".js"):
                yield path.relative_to(ROOT).as_posix(), path.read_text("utf-8")


def test_no_other_file_of_the_product_names_or_compares_experiments() -> None:
    names = [name for name in EXPERIMENTS if name not in (NAME, "ball")]
    quoted, ball = re.compile("|".join(f"[\"']{name}[\"']" for name in names)), re.compile("[\"']ball[\"']")
    compared = re.compile(r"\bif [^\n]*\bscene (?:==|!=|in|not in) |\bmatch [^:\n]*\.scene\b")
    # Figures have their own names, some of them equal to experiments.
    assert {file for file, text in sources() if quoted.search(text)} == {
        "scenes/experiments.py",
        "app/features/figures/figure_list.py",
    }
    assert {file for file, text in sources() if ball.search(text)} - NOT_THE_SCENE == {
        "scenes/experiments.py"
    }
    # These compare two scenes with each other.
    assert {file for file, text in sources() if compared.search(text)} == {
        "scenes/inputs_file.py",
        "app/features/bench/measurements.py",
    }
    assert set(EXPERIMENT_TEXTS) == set(EXPERIMENTS)


NOT_THE_SCENE = {
    "app/features/figures/fig1_path.py",
    "app/features/lessons/scripts.py",
    "app/features/lessons/setups.py",
    "app/features/jupyter/duet.py",
    "app/page/handles/transform_handles.py",
    "app/page/panels/contact_card.py",
    "app/plots/pair_strips.py",
    "app/stage/contact_view.py",
    "scenes/ball.py",
    "scenes/settings.py",
    "scenes/surroundings.py",
    "scenes/targets.py",
}
"""Files in which "ball" is an obstacle, a body, a setting, a handle or a word on the page."""
