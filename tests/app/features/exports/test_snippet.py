"""Copied texts: Python lines that repeat the run, and a link to the settings or to the lesson."""

import io
import runpy
from contextlib import chdir, redirect_stdout
from pathlib import Path
from urllib.parse import parse_qsl, urlencode, urlsplit

import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib import pyplot

from app.features.exports import python_snippet as snippet_module
from app.features.exports.python_snippet import MOST_CHARACTERS, Snippet, as_python, is_fresh, settings_python
from app.features.lessons.loading import load_lessons
from app.features.lessons.panel.lesson_visit import open_link
from app.page.panels.link_box import link_query, link_to
from app.session.session import Session
from app.settings import WHOLE, Settings, from_query, to_query
from app.web.pages import page_query
from controllers.kinematics import Array
from scenes.history import COLUMN
from scenes.inputs import KEEP, InputsLog, Recorded
from scenes.setting_spec import Spec
from scenes.settings import LawSettings, RunSettings, changed, specs, values
from scenes.simulation import Simulation
from tests.app.features.lessons.helpers import lessons_in
from tests.app.recording.runs import piece
from tests.scenes.helpers import given_settings
from tests.scenes.inputs.helpers import everything


def a_value(spec: Spec, present: object) -> st.SearchStrategy[object]:
    if spec.choices:
        return st.sampled_from(spec.choices)
    if spec.read is not None:
        return st.sampled_from(("0.1:1,0.2:0", "0:0.5,0.15:0.25,0.4:0.5"))
    if isinstance(present, bool):
        return st.booleans()
    if isinstance(present, int):
        return st.integers(int(spec.low), int(spec.high))
    return st.floats(spec.low, spec.high)


@st.composite
def any_settings(draw: st.DrawFn) -> Settings:
    settings, present, known = Settings(), values(Settings()), specs(Settings)
    for key in draw(st.sets(st.sampled_from(list(known)))):
        settings = changed(settings, key, draw(a_value(known[key], present[key])))
    return settings


@given(any_settings(), any_settings())
def test_a_link_gives_the_same_settings_on_any_server(settings: Settings, start: Settings) -> None:
    path = urlsplit(link_to("http://a", to_query(settings)))
    assert from_query(page_query(f"{path.path}?{path.query}"), start) == (settings, ())


@given(any_settings(), any_settings())
def test_a_link_omits_what_the_receiver_knows(settings: Settings, known: Settings) -> None:
    said = to_query(settings, known)
    del said[WHOLE]
    assert from_query(said, known) == (settings, ())
    assert len(said) == sum(values(settings)[key] != value for key, value in values(known).items())


def test_a_link_omits_default_values() -> None:
    assert to_query(Settings()) == {WHOLE: "1"}
    assert to_query(changed(changed(Settings(), "dm", 0.1), "autopilot", False)) == {
        "dm": "0.1",
        "autopilot": "0",
        WHOLE: "1",
    }
    # Without `WHOLE`, a link keeps the settings that it does not name.
    start = changed(Settings(), "rig", "table")
    assert from_query({"dm": "0.1"}, start)[0].run.rig == "table"


@pytest.mark.parametrize(("step", "key", "value"), [(0, "k", 5.0), (2, "k", 0.5)])
def test_a_link_to_a_lesson_opens_its_step_with_the_changed_settings(
    step: int, key: str, value: float
) -> None:
    book = load_lessons()
    session = Session(changed(Settings(), "dm", 0.2))
    run = lessons_in(session, book)
    run.enter(0, step)
    session.change(key, value)
    session.change("theme", "dark")
    query = link_query(session)
    assert query == {
        "lesson": book.lessons[0].id,
        "step": str(step + 1),
        key: str(value),
        "theme": "dark",
        WHOLE: "1",
    }

    query = dict(parse_qsl(urlencode(query)))
    settings, problems = from_query(query, Settings())
    there = Session(settings)
    again = lessons_in(there, book)
    assert (problems, open_link(again, query, None)) == ((), ())
    assert (again.walk.lesson, again.walk.step) == (run.walk.lesson, run.walk.step)
    assert there.settings == session.settings


def executed(snippet: Snippet, folder: Path) -> tuple[str, Array]:
    """Output of the lines in a folder with only the files that they need, and their d."""
    folder.mkdir()
    if snippet.inputs is not None:
        (folder / "mine.duet.npz").write_bytes(snippet.inputs)
    (folder / "snippet.py").write_text(snippet.text, encoding="utf-8")
    with chdir(folder), redirect_stdout(io.StringIO()) as said:
        made = runpy.run_path("snippet.py", run_name="__main__")
    pyplot.close(made["figure"])
    plot = (folder / "mine.png").read_bytes()
    assert plot.startswith(b"\x89PNG") and len(plot) > 10_000
    return said.getvalue(), made["table"][:, COLUMN["d"]]


def test_the_lines_compute_and_plot_the_chosen_piece_with_its_settings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    snippets, tables = dict[str, Snippet](), dict[str, Array]()
    for how in ("settings", "in the text", "in a file"):
        monkeypatch.setattr(snippet_module, "MOST_CHARACTERS", 100 if how == "in a file" else MOST_CHARACTERS)
        whole, table = piece("hold", 2.5, lively=how != "settings")
        recorded, _ = piece("hold", 2.5, 0.5, lively=how != "settings")
        assert recorded.seconds > 0.45
        snippet = as_python(whole, recorded, 0.4, "mine")
        assert len(snippet.text.splitlines()) <= 30 and (snippet.inputs is not None) == (how == "in a file")
        assert ("base64" in snippet.text) == (how == "in the text") and (
            "LawSettings" not in snippet.text or how != "settings"
        )
        steps = round(0.4 / recorded.stretches[-1].settings.dt)
        if how != "settings":
            assert f"from t = {table[-steps, COLUMN['t']]:.6g} s to 2.5" in snippet.text
        snippets[how], tables[how] = snippet, table[-steps:]
    monkeypatch.undo()
    whole, tables["all of it"] = piece("hold", 2.5, lively=True)
    snippets["all of it"] = as_python(whole, whole, KEEP, "mine")
    alone, _ = piece("solo", 0.5)
    snippets["an arm alone"] = as_python(alone, alone, 30.0, "mine")
    assert "d_m" not in snippets["an arm alone"].text and "e²" in snippets["an arm alone"].text
    for how, table in tables.items():
        said, d = executed(snippets[how], tmp_path / how)
        assert d.tobytes() == table[:, COLUMN["d"]].tobytes(), how
        assert how == "all of it" or (
            f"steps={len(d)}," in said and f"Summary(d_min={float(d.min())!r}," in said
        )


def test_only_an_unchanged_autopilot_run_from_the_start_is_fresh() -> None:
    recorded, _ = piece("hold", 1.0)
    assert is_fresh(recorded)
    assert not is_fresh(piece("hold", 2.0, 0.9)[0])  # does not begin at the start
    assert not is_fresh(piece("hold", 1.0, lively=True)[0])  # settings changed during the run
    assert not is_fresh(touched(at=150, start=None))  # the handle was released
    simulation = Simulation(RunSettings())
    assert not is_fresh(touched(at=9999, start=simulation.room.start + 0.01))  # another start posture


def touched(at: int, start: object) -> Recorded:
    simulation, log = Simulation(RunSettings()), InputsLog()
    simulation.reset(start)  # pyright: ignore[reportArgumentType]
    person = simulation.source()
    for step in range(200):
        target = person.target(simulation.time) if step < at else None
        log.record(simulation, target)
        simulation.step(target)
    return everything(log)


def test_settings_as_python_are_the_settings() -> None:
    settings = given_settings(scene="imitation", dm=0.2, ff="1", seed=7, law="strict_switched", robot="panda")
    names = {"RunSettings": RunSettings, "LawSettings": LawSettings}
    assert eval(settings_python(settings), names) == settings
    assert settings_python(RunSettings()) == "RunSettings()"
