"""Answers to wrong teacher keys are delayed; the right key never waits."""

import threading

import pytest

from app.hosting.teacher_key import LONGEST, MOST_ADDRESSES, Guesses
from tests.app.conftest import Join, OpenHouse
from tests.app.features.lecture.lecture_room import lecture_of
from tests.app.page.by_hand import WRIST
from tests.app.runtime.processes import until
from tests.blocking_client import BlockingClient

LEADER = f"resume={'1' * 32}"
LINK = f"/arms/right{WRIST}"


def test_wrong_keys_wait_one_second_each_and_the_right_key_never() -> None:
    now, wrong, right = 0.0, {"key": "chalk"}, {"key": "chalk-dust"}
    guesses, keyless = (Guesses(key, lambda: now) for key in ("chalk-dust", None))
    for now, address, query, delay in (  # noqa: B007  the clock reads it
        (5.0, "here", wrong, 1.0),
        (5.0, "here", wrong, 2.0),
        (5.5, "here", right, 0.0),
        (5.5, "here", {}, 0.0),
        (5.5, "here", wrong, 2.5),
        (5.5, "there", wrong, 1.0),
        (60.0, "here", wrong, 1.0),
    ):
        assert guesses.delay(address, query) == pytest.approx(delay)
        assert keyless.delay(address, query) == 0.0
    assert max(guesses.delay("here", wrong) for _ in range(100)) == LONGEST
    for i in range(MOST_ADDRESSES + 5):
        guesses.delay(f"{i}", wrong)
    assert len(guesses._wrong) == MOST_ADDRESSES


def test_the_teacher_enters_while_a_student_with_the_same_address_guesses(
    house: OpenHouse, join: Join
) -> None:
    opened = house(lecture=True, key="chalk-dust")
    done = threading.Event()

    def guess() -> None:
        while not done.is_set():
            BlockingClient(opened.url, query="key=chalk-guess").close()

    guessers = [threading.Thread(target=guess) for _ in range(4)]
    for one in guessers:
        one.start()
    try:
        until(lambda: opened.server._delayed == 4)
        teacher = join(opened, f"{LEADER}&key=chalk-dust")
        teacher.wait_for(lambda v: LINK in v.mirror.grabbable)
        assert lecture_of(opened).controls.operator is not None
    finally:
        done.set()
        for one in guessers:
            one.join()
