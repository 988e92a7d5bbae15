"""New pages are built one at a time and piece by piece, and what a tab asked for goes with it. Every frame is made by hand here."""

import itertools

import pytest

from app.classroom.lecture import LectureHost
from app.hosting import admission
from app.hosting.private_host import PrivateHost
from app.hosting.visitor import Visitor
from app.settings import Settings
from scenes.settings import specs
from tests.app.conftest import FRAME, Made


@pytest.fixture
def pieces(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, int]]:
    """What is done in order, on a machine on which every piece takes as long as there is: (piece or frame, client id)."""
    monkeypatch.setattr(admission, "SLICE", 0.0)
    done: list[tuple[str, int]] = []
    build, frame = Visitor.build, Visitor.frame

    def building(visitor: Visitor) -> admission.Pieces:
        for _ in build(visitor):
            done.append(("piece", visitor.client.client_id))
            yield

    def drawing(visitor: Visitor, now: float, elapsed: float) -> bool:
        done.append(("frame", visitor.client.client_id))
        return frame(visitor, now, elapsed)

    monkeypatch.setattr(Visitor, "build", building)
    monkeypatch.setattr(Visitor, "frame", drawing)
    return done


def test_other_visitors_have_a_frame_between_any_two_pieces(by_hand: Made, pieces: list[tuple[str, int]]) -> None:
    opened = by_hand(sessions=8)
    assert isinstance(opened.host, PrivateHost)
    opened.let_in()
    (neighbour,) = opened.host.sessions
    pieces.clear()
    newcomers = [opened.come() for _ in range(3)]
    while len(opened.host.sessions) < 4:
        before = len(opened.host.sessions)
        opened.frame()
        assert len(opened.host.sessions) <= before + 1
    built = [number for what, number in pieces if what == "piece"]
    # One after the other, each in several pieces.
    assert sorted(built) == built and all(built.count(number) >= 3 for number in set(built)) and len(set(built)) == 3
    places = [place for place, (what, _) in enumerate(pieces) if what == "piece"]
    assert all(("frame", neighbour) in pieces[a:b] for a, b in itertools.pairwise(places))
    for visitor in newcomers:
        # A page is sent as a whole.
        visitor.wait_for(lambda v: v.mirror.replayed and len(v.mirror.commands) >= 14 and "/arms/left/base" in v.mirror.nodes)


@pytest.mark.parametrize("lecture", [False, True])
def test_while_there_is_time_one_page_is_built_in_a_frame(by_hand: Made, monkeypatch: pytest.MonkeyPatch, lecture: bool) -> None:
    monkeypatch.setattr(admission, "SLICE", 1e9)
    opened = by_hand(sessions=8, lecture=lecture)
    host = opened.host
    for _ in range(3):
        opened.come()
    for count in (1, 2, 3):
        opened.frame()
        built = host.visitors if isinstance(host, PrivateHost) else host.participants
        assert len(built) == count and host.admission.busy == (count < 3)


def test_a_page_that_is_closed_half_built_is_given_up_for_the_next_one(by_hand: Made, pieces: list[tuple[str, int]]) -> None:
    opened = by_hand(sessions=8)
    assert isinstance(opened.host, PrivateHost)
    hasty, patient = opened.come(), opened.come()
    while not pieces:
        opened.frame()
    opened.leave(hasty)
    gone = pieces[-1][1]
    opened.frames()
    assert gone not in opened.host.sessions and len(opened.host.sessions) == 1
    patient.wait_for(lambda v: len(v.mirror.commands) >= 14)


@pytest.mark.parametrize("lecture", [False, True])
def test_what_a_tab_asked_for_goes_with_it_but_no_answer_of_a_student(by_hand: Made, lecture: bool) -> None:
    opened = by_hand(lecture=lecture)
    visitor, host = opened.let_in("resume=0123456789abcdef0123456789abcdef"), opened.host
    session = host.session if isinstance(host, LectureHost) else next(iter(host.sessions.values()))
    settings = session.settings
    visitor.wait_for(lambda v: len(v.mirror.commands) >= 14)
    visitor.set_value(specs(Settings)["scene"].label, "A ball in the way (Fig. 1)")
    visitor.wait_for(lambda _: len(session.posts))
    if isinstance(host, LectureHost):
        host.control.post_answer("a student", 0)
        host.control.post_answer("a student", 1)
    opened.leave(visitor)
    assert not isinstance(host, LectureHost) or len(host.control.answers) == 1
    opened.frame()
    assert not len(session.posts) and not (isinstance(host, LectureHost) and len(host.control.answers))
    session.advance(FRAME)
    assert session.settings == settings
