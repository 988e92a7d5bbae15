"""A lecture's hosting: admission, load, damaged store, jobs, proxies, no editor for laws."""

import logging
import multiprocessing
import sqlite3
import urllib.error
import urllib.request
from contextlib import closing
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest

from app.features.lecture.teacher_control import Answer
from app.features.store.session_store import store_of
from app.hosting import admission
from app.runtime.job_pool import JobPool
from app.settings import Settings
from app.web.pages import ROOM_IS_FULL
from scenes.settings import specs
from tests.app.conftest import FRAME, Join, Made, OpenHouse, ask
from tests.app.features.custom_law.helpers import edited
from tests.app.features.custom_law.test_edited_law import PLACE
from tests.app.features.lecture.lecture_room import KEY, Come, lecture_of, operator_of, tab_of
from tests.app.features.studies.test_jobs_of_visitors import compute_for
from tests.app.hosting.test_reconnect import WORD
from tests.app.page.helpers import notes, shown
from tests.app.runtime.processes import until
from tests.app.runtime.test_job_pool import load
from tests.app.web.conftest import ended
from tests.app.web.test_behind_a_proxy import Proxy, proxies
from tests.blocking_client import BlockingClient

__all__ = ["proxies"]


def test_while_there_is_time_one_page_is_built_in_a_frame(
    by_hand: Made, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(admission, "SLICE", 1e9)
    opened = by_hand(sessions=8, lecture=True)
    host = lecture_of(opened)
    for _ in range(3):
        opened.come()
    for count in (1, 2, 3):
        opened.frame()
        assert len(host.participants) == count and host.admission.busy == (count < 3)


def test_queued_actions_go_with_the_teachers_tab_but_answers_stay(by_hand: Made) -> None:
    opened = by_hand(lecture=True)
    visitor, host = opened.let_in("resume=0123456789abcdef0123456789abcdef"), lecture_of(opened)
    session, settings = host.session, host.session.settings
    visitor.wait_for(lambda v: len(v.mirror.commands) >= 14)
    visitor.set_value(specs(Settings)["scene"].label, "A ball in the way (Fig. 1)")
    visitor.wait_for(lambda _: len(session.posts))
    host.control.answers.put(Answer("a student", 0))
    host.control.answers.put(Answer("a student", 1))
    opened.leave(visitor)
    assert len(host.control.answers) == 1
    opened.frame()
    assert not len(session.posts) and not len(host.control.answers)
    session.advance(FRAME)
    assert session.settings == settings


def test_the_teacher_sees_the_number_of_sessions_at_work(house: OpenHouse, join: Join) -> None:
    opened = house(sessions=6, lecture=True, key="12345678")
    student, teacher = join(opened, "lang=en"), join(opened, "lang=en&key=12345678")
    teacher.wait_for(lambda v: "sessions at work: 1 of 7" in shown(v))
    assert "sessions at work" not in shown(student) and lecture_of(opened).classroom.places.most == 6
    opened.context.workload.places = 3
    until(lambda: lecture_of(opened).classroom.places.most == 3)


def test_a_lost_teacher_connection_costs_the_class_no_frame(
    house: OpenHouse, join: Join, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    opened = house(lecture=True)
    host = lecture_of(opened)
    lecturer = join(opened)
    lecturer.wait_for(lambda v: host.controls.operation is not None and len(v.mirror.commands) >= 14)
    student, first = join(opened), operator_of(host)
    student.wait_for(lambda _: opened.server.count_clients() == 2)
    # viser removes a tab's controls before it reports the disconnection; the test stretches this moment.
    with monkeypatch.context() as patch:
        patch.setattr(host.admission, "changes", lambda: ([], set()))
        lecturer.break_off()
        student.wait_for(lambda _: first not in opened.server.get_clients())
        ask(host.session, lambda s: s.change("plot", "rates"))
        frames = student.received.frames
        student.wait_for(lambda v: v.received.frames > frames + 5)
    student.wait_for(lambda _: host.controls.operator is None)
    assert not [record for record in caplog.records if record.levelno >= logging.ERROR], caplog.text


def test_only_the_teachers_page_reports_a_damaged_store_once(
    house: OpenHouse, join: Join, tmp_path: Path
) -> None:
    opened = house(store=tmp_path / "store", lecture=True)
    store = store_of(opened.context)
    assert store.file is not None and store.file.file is not None
    visitor = join(opened, f"resume={WORD}")
    visitor.wait_for(lambda _: lecture_of(opened).controls.operator is not None, 60.0)
    assert not any("damaged" in note for note in notes(visitor))
    with closing(sqlite3.connect(tmp_path / "store", timeout=60.0)) as file:
        file.execute("DROP TABLE parts")
    visitor.wait_for(lambda v: any("damaged" in note for note in notes(v)), 60.0)
    later = join(opened, f"resume={WORD[::-1]}")
    assert store.state.set_aside and not store.state.problem
    assert [len([note for note in notes(one) if "damaged" in note]) for one in (visitor, later)] == [1, 0]


@pytest.mark.thorough
def test_a_lecture_computes_in_the_background_and_ends_its_processes(house: OpenHouse, join: Join) -> None:
    jobs = JobPool()
    opened = house(lecture=True, jobs=jobs)
    others = set(multiprocessing.active_children())
    compute_for(lecture_of(opened).session, join(opened))
    opened.close()
    assert set(multiprocessing.active_children()) == others
    assert load(jobs)[1] == 0


def test_the_class_gets_the_address_of_the_proxy(proxies: tuple[Proxy, Proxy], house: OpenHouse) -> None:
    rewriting, _ = proxies
    rewriting.behind = house(lecture=True, allowed_origins=(rewriting.origin,)).server.get_port()
    with BlockingClient(
        f"http://127.0.0.1:{rewriting.server_address[1]}/lab/duet", rewriting.origin, query="folder=/lab/duet"
    ) as teacher:
        teacher.wait_for(
            lambda v: any(
                f"{rewriting.origin}/lab/duet" in str(e.get("content")) for e in list(v.mirror.gui.values())
            )
        )


def test_no_law_is_edited_in_a_lecture(house: OpenHouse, join: Join, tmp_path: Path) -> None:
    opened = house(features=(edited(tmp_path / "my_law.py"),), lecture=True)
    visitor = join(opened)
    visitor.wait_for(lambda v: len(v.mirror.commands) >= 14)
    assert PLACE not in str(list(visitor.mirror.gui.values()))


def test_a_failing_students_page_is_logged_and_the_others_get_their_frame(
    by_hand: Made, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    opened = by_hand(lecture=True, key="chalk", sessions=8)
    for name in ("ann", "bo"):
        opened.let_in(f"resume={tab_of(name)}")
    ann, bo = lecture_of(opened).participants.values()
    drawn: list[Any] = []

    def fail(*_: Any) -> None:
        raise RuntimeError("the banner")

    monkeypatch.setattr(ann, "show", fail)
    monkeypatch.setattr(bo, "show", lambda *given: drawn.append(given))
    opened.frame()
    assert len(drawn) == 1 and "a frame of a student's page failed" in caplog.text


def test_a_full_lecture_refuses_students_but_admits_the_teacher(house: OpenHouse, come: Come) -> None:
    opened = house(lecture=True, key=KEY, watchers=2)
    ann, _ = come(opened, "ann"), come(opened, "bob")
    host = lecture_of(opened)
    # Both see the shared session, which takes no place yet.
    ann.wait_for(lambda _: host.session.simulation.time > 0.3 and opened.server.count_clients() == 2)
    assert host.controls.operator is None
    with pytest.raises(urllib.error.HTTPError, match="503") as full:
        urllib.request.urlopen(opened.url, timeout=60)
    assert "2 places" in full.value.read().decode()
    with BlockingClient(opened.url, query="key=wrong") as late:
        assert ended(late)[1] == ROOM_IS_FULL
    teacher = come(opened, key=KEY)
    with urllib.request.urlopen(f"{opened.url}/?key={quote(KEY)}", timeout=60) as page:
        assert page.status == 200
    teacher.wait_for(lambda _: host.controls.operator is not None)
    assert ann.closed is None and teacher.closed is None
