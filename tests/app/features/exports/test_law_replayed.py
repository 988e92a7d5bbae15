"""A run under a custom law is saved with the law's answers and replayed bit for bit without the law."""

import io
from pathlib import Path

import numpy as np
import pytest

from app.features.custom_law.student_law import let_custom_law_run
from app.features.exports.csv_table import csv_bytes
from app.features.exports.export_queue import ExportQueue, File
from app.features.exports.player import player_html
from app.features.exports.plot_pictures import picture_bytes
from app.features.exports.recorded_curves import Curves
from app.features.store.record_bytes import record_from_bytes, record_to_bytes
from app.recording.run_file import load_run, saved_bytes
from app.session.frame import freeze
from app.session.session import Session
from app.settings import PageSettings, Settings
from controllers.errors import BadInputFile, BadSetting
from controllers.kinematics import Array
from scenes.inputs import KEEP, InputsLog, Recorded
from scenes.inputs_file import recorded_bytes
from scenes.rerun import newest_piece, rerun
from scenes.settings import RunSettings
from tests.app.features.custom_law.helpers import PAPER, session_of, write
from tests.app.inline import Inline
from tests.app.runtime.processes import until
from tests.approved import Approve
from tests.scenes.inputs.helpers import as_bytes, rewritten

pytestmark = pytest.mark.slow

COUNTED = "    calls = 0\n" + PAPER.replace(
    "\n        c =", "\n        global calls\n        calls += 1\n        c ="
).replace("MU**2)", "MU**2) + 1e-4 * (calls % 7)")
"""The paper's law with a memory: the same call gives different answers."""

FAILING = COUNTED.replace("calls += 1\n", "calls += 1\n        assert calls < 120\n")


def ran(session: Session, steps: int) -> None:
    until(lambda: session.advance(0.03) < 0 or session.simulation.steps >= steps)


def queue_of(session: Session) -> ExportQueue:
    return ExportQueue(session, session.player)


def kept(queue: ExportQueue, background: Inline) -> File:
    queue.ask("run", KEEP)
    background.work()
    queue.player.advance(0.0)
    assert not queue.session.notices
    (file,) = queue.take_files()
    return file


CASES: dict[str, tuple[str, dict[str, object]]] = {
    "fails": (FAILING, {"scene": "hold"}),
    "both": (COUNTED, {"scene": "imitation", "avoid": "both"}),
    "coupled": (COUNTED, {"scene": "imitation", "avoid": "both", "coupled": True}),
    "late": (COUNTED, {"scene": "ball", "dead": 0.02, "fps": 50.0}),
}


@pytest.mark.parametrize("case", CASES)
def test_a_saved_run_is_replayed_bit_for_bit_without_its_law(file: Path, case: str, approve: Approve) -> None:
    text, settings = CASES[case]
    write(file, text)
    background = Inline()
    with session_of(file, background, **settings) as session:
        queue = queue_of(session)
        ran(session, 80)
        session.change("k", 3.0)
        if case == "both":
            session.change("avoid", "free")
        ran(session, 160)
        assert bool(session.law_status.problem) == (case == "fails")
        table, digest = session.simulation.history.table(), session.law_status.sha256
        saved = kept(queue, background)
        queue.player.watch(KEEP)
        background.work()
        queue.player.advance(0.0)
        past = queue.player.past
        assert past is not None and past.law_status.file == "my_law.py"
    file.unlink()

    queue = queue_of(Session(Settings(), background=background))
    queue.load(saved.content, saved.name)
    for _ in range(2):
        background.work()
        queue.player.advance(0.0)
    (news,) = queue.session.notices
    queue.session.notices.clear()
    assert digest[:12] in news[1] and news[1].startswith(saved.name)
    said = "\n".join(news).replace(digest[:12], "SHA").replace(saved.name, "NAME")
    approve("loaded run of a law.txt", f"{said}\n")
    replay = queue.player.replay
    assert replay is not None and replay.recorded.law is not None and replay.recorded.law.sha256 == digest
    assert rerun(replay.recorded).table.tobytes() == table.tobytes()
    for step in (1, replay.steps, 7, 100):
        replay.seek_step(step)
        assert replay.simulation.history.table(1)[0].tobytes() == table[step - 1].tobytes()
    # A part of it is a complete run that can be saved again.
    part = newest_piece(replay.recorded, 0.3)
    assert rerun(part).table.tobytes() == table[-len(rerun(part).table) :].tobytes() and part.steps < len(
        table
    )
    assert kept(queue, background).content == saved.content
    assert queue.player.past is not None and freeze(queue.player.past, 0.0).shown.law_status.sha256 == digest


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Recorded, Array]:
    """A run with two settings under the law of a file, and its table."""
    with session_of(write(tmp_path_factory.mktemp("law") / "my_law.py", COUNTED)) as session:
        ran(session, 80)
        session.change("k", 3.0)
        ran(session, 160)
        recorded = session.inputs.window()
        assert recorded is not None
        return recorded, session.simulation.history.table(recorded.steps)


def test_table_picture_and_page_show_the_answers(made: tuple[Recorded, Array]) -> None:
    recorded, table = made
    assert recorded.law is not None
    lines = csv_bytes(recorded, np.inf).decode().splitlines()
    assert "# law = my_law.py" in lines and f"# law_sha256 = {recorded.law.sha256}" in lines
    assert (
        not any("smooth_priority" in line for line in lines)
        and float(lines[-1].split(",")[1]) == table[-1, 1]
    )
    page = player_html(recorded, 0.3, PageSettings(details="stability")).decode()
    assert f"my_law.py (SHA-256 {recorded.law.sha256[:12]}…)" in page
    assert "Smooth priority" not in page.split('id="duet-plots"')[1].split("</h1>")[0]
    drawn = picture_bytes(recorded, 2.0, "laws", "svg")
    assert drawn == picture_bytes(recorded, 2.0, "none", "svg")
    assert np.isnan(Curves(recorded, table).column("d*")).all()


def test_exports_that_need_the_law_are_refused(made: tuple[Recorded, Array]) -> None:
    recorded, _ = made
    for asked in ({"overrides": {"n": 8.0}}, {"substeps": 2}):
        with pytest.raises(BadSetting, match=r"my_law\.py runs in its"):
            rerun(recorded, **asked)  # pyright: ignore[reportArgumentType]
    background = Inline()
    queue = queue_of(Session(Settings(), background=background))
    queue.load(saved_bytes(recorded), "a.npz")
    for _ in range(2):
        background.work()
        queue.player.advance(0.0)
    queue.session.notices.clear()
    queue.ask("python", 1.0)
    ((_, news),) = queue.session.notices
    assert "my_law.py" in news and not background.waiting()


def test_a_record_of_a_session_keeps_the_answers(made: tuple[Recorded, Array], file: Path) -> None:
    recorded, table = made
    back = record_from_bytes(record_to_bytes(recorded), Recorded)
    assert rerun(back).table.tobytes() == table.tobytes()
    # A session continues from them only under a custom law.
    with session_of(write(file, PAPER)) as session:
        for own in (True, False):
            let_custom_law_run(session, own)
            session.inputs.restore([back], session.simulation)
            assert (session.inputs.window(KEEP) is not None) == own


def test_a_run_has_one_kind_of_law(file: Path) -> None:
    with session_of(write(file, PAPER)) as session:
        ran(session, 40)
        law, simulation = session.simulation.law, session.simulation
        for other in (None, law):
            simulation.use(other)
            before = simulation.steps
            ran(session, before + 20)
            recorded = session.inputs.window()
            assert (
                recorded is not None
                and recorded.snapshot.steps == before
                and (recorded.law is None) == (other is None)
            )
            assert rerun(recorded).table[-1].tobytes() == simulation.history.table(1).tobytes()


def test_answers_count_towards_the_memory_limit(file: Path) -> None:
    with session_of(write(file, PAPER)) as session:
        session.inputs = InputsLog(most_bytes=60_000)
        ran(session, 1400)
        assert session.inputs.nbytes < 110_000
        recorded = session.inputs.window()
        assert recorded is not None and recorded.seconds < 4.0
        assert rerun(recorded).table[-1].tobytes() == session.simulation.history.table(1).tobytes()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"answers": -1}, r"has \d+ numbers as answers of its law, but its steps need \d+"),
        ({"answers": None}, "answers"),
        ({"answers": np.nan}, "impossible answers"),
        ({"answers": 2.0}, "impossible answers"),
        ({"law_sha256": "ab"}, "does not name"),
        ({"law_file": ""}, "does not name"),
        ({"law_file": "a\nb"}, "does not name"),
    ],
)
def test_a_file_with_wrong_answers_is_refused(
    made: tuple[Recorded, Array], change: dict[str, object], message: str
) -> None:
    data = saved_bytes(made[0])
    with np.load(io.BytesIO(data)) as arrays:
        about, answers = arrays["about"].tobytes().decode(), arrays["answers"].copy()
    assert '"version": 2' in about and '"version": 1' in recorded_about(Session(Settings()))
    assert made[0].law is not None
    parts: dict[str, np.ndarray | None] = {}
    for name, value in change.items():
        if name != "answers":
            before = made[0].law.file if name == "law_file" else made[0].law.sha256
            parts["about"] = as_bytes(about.replace(f'"{before}"', f'"{value}"'.replace("\n", "\\n")))
        elif value is None or value == -1:
            parts["answers"] = None if value is None else answers[:-8]
        else:
            answers[0] = value
            parts["answers"] = answers
    with pytest.raises(BadInputFile, match=message):
        load_run(rewritten(data, **parts), "mine.npz")


def recorded_about(session: Session) -> str:
    """The `about` part of a file whose run has no custom law; checks that the file has no answers."""
    session.advance(0.05)
    recorded = session.inputs.window()
    assert recorded is not None and recorded.settings == RunSettings()
    with np.load(io.BytesIO(recorded_bytes(recorded))) as arrays:
        assert "answers" not in arrays.files
        return arrays["about"].tobytes().decode()
