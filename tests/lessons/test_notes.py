"""The teacher's notes, step by step."""

import pytest

from app.lessons.loading import load_lessons, load_notes
from app.lessons.notes import Notes, StepNotes, read_notes
from app.page.panels.notes_panel import notes_html


@pytest.mark.parametrize(
    ("text", "notes"),
    [
        (
            "# For *me*\n\nAll.\n\n## 2. The switch\nA.\n### Deep\nB.\n## 1\nC.\n",
            Notes("For *me*", "All.", (StepNotes(2, "The switch", "A.\n### Deep\nB."), StepNotes(1, "", "C."))),
        ),
        ("", Notes("", "", ())),
        ("just a word", Notes("", "just a word", ())),
        ("# Title", Notes("Title", "", ())),
        ("a\n## Without a number\nb", Notes("", "a\n## Without a number\nb", ())),
        ("## 3: c", Notes("", "", (StepNotes(3, "c", ""),))),
        ("a\n## 3rd floor", Notes("", "a\n## 3rd floor", ())),
    ],
)
def test_notes_need_no_form_but_a_heading_with_a_number_begins_a_step(text: str, notes: Notes) -> None:
    assert read_notes(text) == notes


def test_our_notes_have_a_part_for_every_step() -> None:
    texts = load_notes()
    for lesson in load_lessons().lessons:
        notes = read_notes(texts[lesson.id])
        assert [(part.number, part.title) for part in notes.steps] == [(i, s.title) for i, s in enumerate(lesson.steps, 1)]
        assert notes.text.startswith(f"{lesson.minutes} minutes")
        for part in notes.steps:
            assert "minutes" in part.text.partition("\n")[0] and "**Answers.**" in part.text
        assert sum(int(part.text.split()[0]) for part in notes.steps) == lesson.minutes


def test_the_present_step_comes_first_and_nothing_is_left_out() -> None:
    notes = read_notes("# Title\nWhole.\n## 1. One\nA <b>.\n## 2. Two\nB.")
    for step, order in ((1, ("1. One", "Title", "Whole", "2. Two")), (2, ("2. Two", "Title", "Whole", "1. One"))):
        made = notes_html(notes, step)
        places = [made.index(text) for text in order]
        assert places == sorted(places) and made.count('class="now"') == 1 and made.count("<section") == 2
        assert "A &lt;b&gt;." in made
    # A step that the notes say nothing about.
    assert 'class="now"' not in notes_html(notes, 3)
