"""The overlay of a projector's scene, without a page: only counts before the reveal, the answers after it."""

import re
from dataclasses import replace

from app.features.classroom.ballots import Tally
from app.features.lecture.presenter import Station
from app.features.lessons.session.lesson_actions import GoTo
from app.plots.curve_chart import COLUMNS
from app.settings import LANGUAGES
from tests.app.features.lecture.presenter_stage import BOOK, Stage, screen
from tests.approved import Approve, shown_text


def meter_of(overlay: str) -> str:
    """Count of answers, and the timer."""
    return shown_text(re.findall(r"<footer>.*?</footer>", overlay, re.DOTALL)[-1])


def test_before_the_reveal_the_screen_shows_only_counts(stage: Stage, approve: Approve) -> None:
    poll = stage.control.poll()
    assert poll is not None
    poll = replace(poll, tally=Tally((1, 2, 14, 0), 13, 17))
    asked = screen(stage, poll, Station.QUESTION, 45)
    said = [meter_of(asked)]
    assert ">0:45<" in asked and "14" not in asked and "82" not in asked
    assert asked.count("<li") == len(poll.choices) == 4 and asked.count("width:0%") == 4
    drawn = replace(poll, tally=Tally((1, 0, 0, 0), 0, 3, ((0.5,),) * 3))
    asked = screen(stage, drawn, Station.QUESTION, 45)
    assert "width:100%" in asked
    said += [meter_of(asked), meter_of(screen(stage, poll, Station.QUESTION, 0))]
    approve("count and clock of the screen.txt", "\n".join(said))
    told = screen(stage, replace(poll, open=False, revealed=True), Station.ANSWERS, 45)
    assert "width:82%" in told and "0:45" not in told and "right" not in told
    # After *Ask again*, the first round is hidden until the second is revealed.
    second = replace(poll, first=Tally((3, 20, 5, 0), 2, 28), round=2)
    assert "Round" not in screen(stage, second, Station.QUESTION) and "71" not in screen(
        stage, second, Station.QUESTION
    )
    both = screen(stage, replace(second, open=False, revealed=True), Station.ANSWERS)
    assert "Round 1" in both and "width:71%" in both and "width:82%" in both
    # The scene shows the count from the first answer on.
    assert "17 of 30" in screen(stage, poll, Station.SCENE)
    assert "answered" not in screen(stage, replace(poll, tally=Tally((0,) * 4, 0, 0)), Station.SCENE)
    known = replace(poll, open=False, revealed=True, outcome=("4 ways",), right=2)
    assert 'class="right"' in screen(stage, known, Station.OUTCOME) and "4 ways" in screen(
        stage, known, Station.OUTCOME
    )


def test_a_question_for_a_curve_shows_axes_without_a_curve(stage: Stage) -> None:
    stage.lessons.act(
        GoTo(3, next(i for i, step in enumerate(BOOK.lessons[3].steps) if step.drawing is not None))
    )
    stage.frame()
    poll = stage.control.poll()
    assert poll is not None and poll.drawing is not None
    curve = tuple(0.5 for _ in range(COLUMNS))
    poll = replace(poll, tally=Tally((1, 0, 0, 0), 0, 1, (curve,)))
    asked, told = (
        screen(stage, poll, Station.QUESTION),
        screen(stage, replace(poll, revealed=True), Station.ANSWERS),
    )
    assert "<figure" in asked and "1 drawn" not in asked and "median" not in asked
    assert "1 drawn" in told and "median" in told


def test_no_text_of_a_step_names_a_plot_by_its_position() -> None:
    elsewhere = re.compile(
        r"(second|other|left|right|lower|upper) plot|(zweite|andere|linke|rechte)\w* Diagramm|drug\w+ graf|formula below"
    )
    for language in LANGUAGES:
        for lesson in BOOK.in_language(language).lessons:
            for step in lesson.steps:
                asked = "" if step.question is None else step.question.text
                for text in (step.goal, asked, step.do, step.observe):
                    assert not elsewhere.search(text), (language, lesson.id, step.id, text)
