"""`duet.show()` in a real kernel: the document's examples, the numbers, the page in the cell, the end."""

import math
import re
import socket
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import websockets
from jupyter_client.manager import start_new_kernel
from playwright.sync_api import expect

from app.features.jupyter import JUPYTER, duet, notebook_run
from app.features.jupyter.notebook_run import NotebookRun
from app.session.session import Session
from controllers.errors import BadSetting, DuetError
from tests.app.features.jupyter.conftest import TOKEN, JupyterServer, environment
from tests.app.features.said import lines_of
from tests.app.served import has_arms
from tests.approved import Approve
from tests.blocking_client import BlockingClient
from tests.browser import PageAt, screenshot, until

pytestmark = pytest.mark.thorough

DOCUMENT = JUPYTER.documents["jupyter"].file.read_text(encoding="utf-8")
EXAMPLE, *CELLS = re.findall(r"^```ipython\n(.*?)^```", DOCUMENT, flags=re.MULTILINE | re.DOTALL)

Execute = Callable[[str], tuple[str, list[str]]]


@pytest.fixture(scope="module")
def cell(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Execute]:
    """`cell(code)` runs a cell and returns its printed text and its HTML outputs."""
    home = tmp_path_factory.mktemp("kernel")
    manager, client = start_new_kernel(cwd=str(home), env=environment(home))

    def execute(code: str) -> tuple[str, list[str]]:
        printed, shown = [], []

        def take(message: dict[str, Any]) -> None:
            content = message["content"]
            if message["msg_type"] == "stream":
                printed.append(content["text"])
            elif "text/html" in content.get("data", {}):
                shown.append(content["data"]["text/html"])

        reply = client.execute_interactive(code, timeout=120, output_hook=take)["content"]
        if reply["status"] != "ok":
            raise AssertionError(f"{reply['ename']}: {reply['evalue']}")
        return "".join(printed), shown

    try:
        yield execute
    finally:
        client.stop_channels()
        manager.shutdown_kernel(now=True)


@pytest.fixture(scope="module")
def page_html(cell: Execute) -> str:
    """HTML of the document's own example; its run continues."""
    printed, (html,) = cell(EXAMPLE)
    law, time, distance = printed.split()[-3:]
    assert law == "smooth_priority" and float(time) >= 9.9 and 0.1 < float(distance) < 0.5
    return html


def port_of(html: str) -> int:
    (port,) = re.findall(r'"port": (\d+)', html)
    return int(port)


def query_of(html: str) -> str:
    (query,) = re.findall(r'"query": "([^"]*)"', html)
    return query


def test_the_history_has_arrays_of_the_displayed_run(cell: Execute, page_html: str, tmp_path: Path) -> None:
    file = tmp_path / "history.npz"
    cell(f"run.advance(5.0)\nimport numpy; numpy.savez({str(file)!r}, **run.history())")
    with np.load(file) as history:
        t, d = history["t"], history["d"]
        assert len(t) >= 3000 and np.allclose(np.diff(t), 0.005) and t[-1] >= 14.9
        assert np.isfinite(d).all() and np.ptp(d) > 0.01
        assert {"lambda", "law_d", "left_q1", "right_q7", "left_dq1", "right_qd7"} <= set(history.files)
        assert all(history[name].shape == t.shape for name in history.files)
    assert cell("print(len(run.history(1.0)['t']))")[0] == "200\n"


def test_a_second_cell_shows_the_same_run_and_may_change_it(cell: Execute, page_html: str) -> None:
    printed, (html,) = cell(
        "again = duet.show(300, n=8, law='strict_priority')\nprint(again is run, run.law.order, run.law.law)"
    )
    assert (
        printed.split() == ["True", "8.0", "strict_priority"]
        and port_of(html) == port_of(page_html)
        and html != page_html
    )
    with pytest.raises(AssertionError, match=r"BadSetting: .*smooth_priority"):
        cell("duet.show(n=9, law='none')")
    state = "print(run.settings.run.law.order, run.settings.run.scene)"
    assert cell(state)[0] == "8.0 hold\n"


def test_the_first_cell_operates_the_run_and_a_foreign_page_needs_the_key(
    cell: Execute, page_html: str
) -> None:
    url, query = f"http://127.0.0.1:{port_of(page_html)}", query_of(page_html)
    with (
        BlockingClient(url, "https://hub.example.org", query=query) as ours,
        BlockingClient(url, query=query[:-1] + "x") as next_cell,
    ):
        ours.wait_for(lambda v: has_arms(v) and len(v.mirror.commands) >= 14)
        next_cell.wait_for(has_arms)
        assert len(next_cell.mirror.commands) < 14
        assert not any(
            "Students" in str(element) or "Follow me" in str(element)
            for element in list(ours.mirror.gui.values())
        )
        ours.close()
        next_cell.wait_for(lambda v: len(v.mirror.commands) >= 14)
    with pytest.raises(websockets.InvalidStatus, match="403"):
        BlockingClient(url, "https://hub.example.org", query="key=a-wrong-one&alone=1")


def test_the_cell_finds_the_page_through_jupyter(
    cell: Execute, page_html: str, jupyter: JupyterServer, page_at: PageAt, tmp_path: Path
) -> None:
    page = page_at(1000, 800, fresh=True)
    page.goto(f"{jupyter.origin}{jupyter.folder}api/status?token={TOKEN}")
    # Jupyter's own pages state their address in this element; the tests' packages do not include JupyterLab.
    config = (
        f'<script id="jupyter-config-data" type="application/json">{{"baseUrl": "{jupyter.folder}"}}</script>'
    )
    page.route(
        "**/lab", lambda route: route.fulfill(content_type="text/html", body=f"<body>{config}{page_html}")
    )
    page.goto(f"{jupyter.origin}{jupyter.folder}lab")
    expect(page.locator("iframe[title=Duet]")).to_be_visible(timeout=60_000)
    frame = page.frames[1]
    frame.wait_for_function("document.documentElement.matches('.duet-built')", timeout=60_000)
    assert frame.url.startswith(f"{jupyter.origin}{jupyter.folder}proxy/{port_of(page_html)}/")
    frame.get_by_text("Pause", exact=True).first.click()
    until(page, lambda: cell("print(run._session.paused)")[0] == "True\n", "the pause in the kernel")
    screenshot(page, "notebook")


def test_the_six_cells_of_the_document(cell: Execute, page_html: str) -> None:
    long_names, table, law, step, lesson = CELLS
    assert cell(long_names)[0] == "0.12 0.12 8.0\n"
    assert re.search(r"count +400\.0", cell(table)[0])
    assert 0.0 < float(cell(law)[0]) < 0.3
    state = "print(run._session.law_status.file, run._session.law_status.problem, run['ghost'])"
    assert cell(state)[0] == "law.py  smooth_priority\n"
    before = float(cell("print(run.history(0.005)['t'][-1])")[0])
    t, *speeds = map(float, cell(step)[0].split())
    # The run continues until the first step pauses it. The protected arm moves as commanded.
    assert t >= before + 0.1 - 1e-6 and 0.2 in [round(speed, 6) for speed in speeds]
    for wrong in ("[0.1]", "[float('nan')] * 7"):
        with pytest.raises(AssertionError, match="7 finite joint velocities"):
            cell(f"run.step({wrong})")
    _, (html,) = cell(lesson)
    assert (
        port_of(html) == port_of(page_html)
        and cell("print(run._app.host.lessons.walk.lesson.number)")[0] == "4\n"
    )
    for wrong in ("99", "'none'", "4, step=99"):
        with pytest.raises(AssertionError, match="BadSetting"):
            cell(f"duet.show(lesson={wrong})")


def test_a_failing_law_of_a_cell_names_the_line_of_the_cell(cell: Execute, page_html: str) -> None:
    cell("run._ask(lambda session: run._app.host.lessons.leave())")
    cell(
        "k = 3\n\ndef broken(situation):\n    return k * situation.nominal / nothing\nduet.law(broken)\nrun.advance(0.1)"
    )
    (problem, _) = cell("print(run._session.law_status.problem)")
    assert "line 4: NameError" in problem
    for wrong in ("lambda s: s.nominal", "3", "print"):
        with pytest.raises(AssertionError, match="BadSetting"):
            cell(f"duet.law({wrong})")


def test_close_ends_the_run_and_the_cell_says_so(
    cell: Execute, page_html: str, jupyter: JupyterServer, page_at: PageAt
) -> None:
    printed, _ = cell("duet.close()\nprint(run)")
    assert printed == "<Duet, closed>\n"
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", port_of(page_html)))
    with pytest.raises(AssertionError, match=r"DuetError: .*duet.show\(\)"):
        cell("run.history()")
    page = page_at(700, 300, fresh=True, expect=("status of 500",))
    page.goto(f"{jupyter.origin}{jupyter.folder}api/status?token={TOKEN}")
    page.route(
        "**/lab",
        lambda route: route.fulfill(
            content_type="text/html", body=f"<body data-base-url='{jupyter.folder}'>{page_html}"
        ),
    )
    page.goto(f"{jupyter.origin}{jupyter.folder}lab")
    expect(page.locator("body")).to_contain_text("This Duet has ended. Run the cell again.", timeout=60_000)


def test_without_a_proxy_in_jupyter_the_cell_gives_a_link(page_at: PageAt, page_html: str) -> None:
    page = page_at(700, 300, fresh=True, expect=("status of 404",))
    page.route("**/*", lambda route: route.fulfill(status=404))
    page.route("**/lab", lambda route: route.fulfill(content_type="text/html", body=f"<body>{page_html}"))
    page.goto("http://localhost:1/lab")
    expect(page.locator("body")).to_contain_text("install jupyter-server-proxy", timeout=60_000)
    expect(page.locator("a")).to_have_attribute(
        "href", f"http://127.0.0.1:{port_of(page_html)}/?{query_of(page_html)}"
    )


@pytest.fixture
def ends() -> Iterator[None]:
    yield
    duet.close()


def resting(situation: Any) -> Any:
    return 0.0 * situation.nominal


def session_of(run: NotebookRun) -> Session:
    return run._session


def test_the_named_law_is_the_one_that_moves_the_arm(ends: None) -> None:
    run = duet.law(resting)
    simulation = session_of(run).simulation

    def named(law: str) -> bool:
        return run.law.law == run["law"] == law and repr(run).endswith(f"hold, {law}>")

    assert named("my own law")
    run.change(law="strict_priority", dm=0.1)
    assert named("strict_priority") and simulation.given_law is None
    duet.law(resting)
    run.change(dm=0.2)
    assert named("my own law") and simulation.given_law is not None
    duet.law(None)
    assert named("strict_priority") and simulation.given_law is None


def test_a_step_waits_for_the_ghosts_law_and_invalid_velocities_are_refused(
    ends: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = duet.show()
    session = session_of(run)
    make, unanswered = session.step_both, [None, None]
    monkeypatch.setattr(
        session, "step_both", lambda: False if unanswered and not unanswered.pop() else make()
    )
    first = run.step(np.zeros(7))
    assert not unanswered
    assert run.step(np.zeros(7))["t"] == pytest.approx(first["t"] + run.settings.run.dt)
    wrong: tuple[Any, ...] = ("a", None, [[0.0], [0.0, 1.0]], [10**400] * 7)
    for dq in wrong:
        with pytest.raises(BadSetting, match="7 finite joint velocities"):
            run.step(dq)
    monkeypatch.setattr(session, "step_both", lambda: False)
    monkeypatch.setattr(notebook_run, "PATIENCE", 0.1)
    with pytest.raises(DuetError, match="does not answer"):
        run.step(np.zeros(7))


def test_a_cell_starts_a_new_run_after_the_previous_one_ended(ends: None) -> None:
    with pytest.raises(BadSetting, match="no lesson 99"):
        duet.show(lesson=99)
    assert duet._running is None
    first = duet.show()
    first.close()
    second = duet.show(dm=0.1)
    assert second is not first and second["dm"] == 0.1
    for lesson, step, said in (
        (99, 1, "no lesson 99; choose from 0 beliefs, 1 "),
        (1, 99, "no step 99 in lesson 1; give 1 to "),
    ):
        with pytest.raises(BadSetting, match=said):
            duet.show(lesson=lesson, step=step, dm=0.2)
    assert second["dm"] == 0.1
    assert duet.show(dm=0.2) is second and second["dm"] == 0.2


WRONG: tuple[Any, ...] = ("x", math.nan, math.inf, None)


def test_impossible_requests_change_nothing(ends: None, approve: Approve) -> None:
    run = duet.show(dm=0.1)
    attempts: dict[str, Callable[[], object]] = {
        "run['foo']": lambda: run["foo"],
        **{f"history({seconds})": partial(run.history, seconds) for seconds in (-1.0, 0.0, *WRONG[:3])},
        **{f"advance({seconds})": partial(run.advance, seconds) for seconds in (-1.0, 1e12, *WRONG[:3])},
        **{f"show(lesson=1, step={step!r})": partial(duet.show, lesson=1, step=step) for step in WRONG},
    }
    said = dict[str, str]()
    for case, attempt in attempts.items():
        with pytest.raises(BadSetting) as error:
            attempt()
        said[case] = str(error.value)
    approve("refusals in a cell.txt", lines_of(said))
    assert run["dm"] == 0.1
