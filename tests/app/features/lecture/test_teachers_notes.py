"""Teacher's notes: only the key opens them, and a wrong key is reported."""

import urllib.request
from urllib.parse import quote

import pytest

from app.features.lessons.library import notes_of
from app.features.lessons.session.lesson_actions import GoTo
from tests.app.conftest import OpenHouse, ask
from tests.app.features.lecture.lecture_room import KEY, WAIT, Class, Come, everything, sees
from tests.app.features.lessons.helpers import our_book
from tests.app.page.helpers import open_lessons

BOOK = our_book()
NOTES = notes_of(BOOK)


def secrets_of(lesson: str) -> list[str]:
    """Phrases that are only in the notes to a lesson, not in its students' texts."""
    lines = [line.strip() for line in NOTES[lesson].splitlines() if len(line.split()) > 5]
    return [" ".join(line.split(" ")[1:5]) for line in lines if not set(line) & set("#*`$“”")] + [
        "Usually believed",
        "Watch out",
    ]


@pytest.mark.thorough
def test_only_the_key_opens_the_notes_and_a_wrong_key_is_reported(classroom: Class, come: Come) -> None:
    opened, host, teacher = classroom.opened, classroom.host, classroom.teacher
    students = [*classroom.come("ann"), come(opened, "bo", "key=chal"), classroom.screen()]
    students += classroom.send("Explore freely", "ann")
    some = [BOOK.lessons[i] for i in (5, 0)]
    for lesson in some:
        ask(host.session, lambda _, lesson=lesson: host.lessons.act(GoTo(lesson.number, 0)))
        sees(teacher, secrets_of(lesson.id)[0])
        sees(students[2], f"Lesson {lesson.number} · step 1")
    students[1].wait_for(lambda _: "not the teacher" in everything(students[1]), WAIT)
    sent, heard = everything(teacher), [everything(student) for student in students]
    for lesson in some:
        words = secrets_of(lesson.id)
        assert len(words) > 3 and any(word in sent for word in words)
        assert not [word for word in words if any(word in one for one in heard)], lesson.id
    assert ["not the teacher" in one for one in heard] == [
        False,
        True,
        False,
        False,
    ] and "not the teacher" not in sent
    # The key is on no page.
    assert not any("chalk" in one or quote(KEY) in one for one in (sent, *heard))
    with urllib.request.urlopen(opened.url, timeout=60) as page:
        assert "Usually believed" not in page.read().decode()


def test_without_a_lecture_only_the_key_opens_the_notes(house: OpenHouse, come: Come) -> None:
    opened = house(key=KEY)
    teacher, bo = come(opened, key=KEY), come(opened, "bo", "key=chal")
    for visitor in (teacher, bo):
        open_lessons(visitor)
        sees(visitor, "Lesson 1 · step 1")
    sees(teacher, "Usually believed")
    bo.wait_for(lambda _: "This is not the teacher's key" in everything(bo).replace("\\'", "'"), WAIT)
    assert "not the teacher" not in everything(teacher) and "Usually believed" not in everything(bo)
