"""A translated lesson contains no English: in steps, outcomes, challenges and the report."""

import re
from collections.abc import Iterator
from dataclasses import replace

import pytest

from app.features.custom_law.trials import verdict_on
from app.features.lessons import outcomes, reference_runs
from app.features.lessons.attempts import StandIn, attempt_of
from app.features.lessons.bookmark import phases_of
from app.features.lessons.labels import label_of, sentence
from app.features.lessons.lesson import Lesson, Step
from app.features.lessons.outcomes import Attempt, judge, judged, reference
from app.features.lessons.progress import StepProgress
from app.features.lessons.reference_runs import simulated
from app.features.lessons.step_view import StepPosition, StepView, make_view
from app.features.lessons.texts import series_table, tabled
from app.features.lessons.walkthrough import Walkthrough
from app.features.measures.evidence import Evidence
from app.i18n.catalogue import catalogues, read_texts
from app.i18n.speaking import set_language, tr
from app.settings import LANGUAGES, TRANSLATIONS, Language
from scenes.settings import LawSettings, RunSettings, values
from tests.app.features.lessons.helpers import our_book, to_challenge
from tests.app.i18n.messages import NAMES

ENGLISH = re.compile(
    r"\b(?:the|and|of|with|you|your|it|what|which|how|than|are|this|that|from|does|not|for|between)\b",
    re.IGNORECASE,
)
"""English words that do not exist in German or Slovene."""

CODE = re.compile(r"`[^`]*`|^ {4}.*$|\]\([^)]*\)", re.MULTILINE)
FORMULA = re.compile(r"\$\$.+?\$\$|\$[^$]+\$", re.DOTALL)
CODE_WORDS = {"nominal + row · c /"}
"""Code in a hint that looks like words."""
WORD = re.compile(r"(?!mrad\b)[A-Za-zÀ-ž]{4}")
"""Four letters, except the unit mrad."""


@pytest.fixture
def no_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """All measurements are 1.0, because only the words matter here."""
    for module in (outcomes, reference_runs):
        monkeypatch.setattr(module, "measured", lambda *_: 1.0)


def attempts(step: Step) -> Iterator[Attempt]:
    """Attempts at a challenge with runs without a value, too low, too high and just right."""
    challenge = step.challenge
    if challenge is None:
        return
    if challenge.custom_law:
        law = StandIn(LawSettings(law="unprotected").made())
        yield attempt_of([verdict_on(law, test) for test in ("leaves the task alone", "gets out")])
    for missed in (None, -1e-3, 1e-3, 0.0):
        judgements = []
        for c in challenge.criteria:
            bounds = [bound for bound in (c.low, c.high) if bound is not None]
            value = None if missed is None else min(bounds) + missed if missed < 0.0 else max(bounds) + missed
            judgements.append(judged(c, value, challenge.setup.seconds))
        yield Attempt.of(judgements)
    if challenge.forecasts:
        evidence = Evidence(simulated(replace(challenge.setup, seconds=0.1)))
        for said in (None, 0.0):
            yield judge(challenge, evidence, [said] * len(challenge.forecasts))


def views(lesson: Lesson, step: Step, index: int) -> Iterator[StepView]:
    """End of a step after each answer, with all possible texts about its run."""
    outcome = replace(reference(step, step.setup), unlike=tuple(values(RunSettings()).items()))
    for choice in range(len(step.question.choices)) if step.question is not None else (None,):
        done = StepProgress(choice, outcome, outcome, len(step.hints))
        yield make_view(
            StepPosition(lesson, step, index, phases_of(step)[-1], done, None), step.yours, False, False
        )


def texts_of(lesson: Lesson, step: Step, index: int) -> Iterator[str]:
    yield from (lesson.title, lesson.goal, lesson.equations, step.title)
    yield from (label_of(m, lesson.language) for m in step.numbers)
    for view in views(lesson, step, index):
        yield from (text for _, text in view.texts)
        yield from (*view.choices, *view.outcome, *view.why_outcome, *view.forecasts, *view.hints)
        if view.verdict is not None:
            yield from (view.verdict.headline, view.verdict.reply)
    for attempt in attempts(step):
        yield from (sentence(tr(judgement.text)) for judgement in attempt.judgements)


def phrases(text: str) -> set[str]:
    """Parts of a text with words, in lower case; of a formula only its words."""
    said = FORMULA.sub(lambda found: ". ".join(re.findall(r"\\text\{(.*?)\}", found[0])), CODE.sub("", text))
    return {
        part.strip(" *_“”„»«>123456").lower()
        for part in re.split(r"[.,:;?!=…()|\n]", said)
        if WORD.search(part)
    }


@pytest.mark.usefixtures("no_runs")
@pytest.mark.parametrize("language", TRANSLATIONS)
def test_no_lesson_falls_back_to_english(language: Language) -> None:
    catalogue = [pair for path in catalogues(language) for pair in read_texts(path).items()]
    same = set[str]().union(
        *(phrases(english) & phrases(text) for english, text in catalogue), *map(phrases, NAMES), CODE_WORDS
    )
    for english, lesson in zip(our_book().lessons, our_book(language).lessons, strict=True):
        assert lesson.language == language
        for index, (before, step) in enumerate(zip(english.steps, lesson.steps, strict=True)):
            set_language("en")
            known = {phrase for text in texts_of(english, before, index) for phrase in phrases(text)}
            set_language(language)
            for text in texts_of(lesson, step, index):
                found = phrases(text)
                assert (found & known) - same == set(), (lesson.id, step.id)
                assert [phrase for phrase in found if ENGLISH.search(phrase)] == [], (lesson.id, step.id)


@pytest.mark.parametrize("language", TRANSLATIONS)
def test_the_verdict_on_an_attempt_changes_its_language_after_a_reload(language: Language) -> None:
    walk = Walkthrough(our_book())
    walk.go("smooth", 2)
    to_challenge(walk)
    simulation = simulated(replace(walk.setup, seconds=0.1))
    assert walk.attempt(simulation) is not None
    again = Walkthrough(our_book(language), walk.to_json())
    attempt, before = again.done.last, walk.done.last
    assert attempt is not None and attempt == before
    set_language(language)
    for said in (attempt.note, *(judgement.text for judgement in attempt.judgements)):
        assert phrases(said) and not phrases(tr(said)) & phrases(said)


def test_names_of_settings_and_ball_places_are_in_the_nominative() -> None:
    said: dict[Language, tuple[str, str]] = {
        "de": ("im Lauf „Gesetz auf ‚", "im Lauf „der Ball "),
        "sl": ("kjer je zakon »", "kjer je žoga "),
    }
    for language, (law, ball) in said.items():
        lines = list[str]()
        for lesson, number in (("strict-priority", 0), ("limits", 1)):
            step = our_book(language).lessons[our_book(language).index(lesson)].steps[number]
            lines += reference(step, step.setup).lines(step, language)
        assert law in " ".join(lines) and ball in " ".join(lines)


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_table_fits_its_panel(language: Language) -> None:
    steps = [step for lesson in our_book().in_language(language).lessons for step in lesson.steps]
    tables = [(step, ids) for step in steps for text in (step.observe, step.explain) if (ids := tabled(text))]
    for step, ids in tables:
        shown = [m for m in step.measurements if m.id in ids]
        lines = series_table(shown, [()] * len(shown), step.setup, language).strip().split("\n")
        rows = [re.split(r"(?<!\\)\|", line)[1:-1] for line in lines]
        # Words are not divided; about 40 letters fit.
        widths = [max(len(word) for word in " ".join(column).split()) for column in zip(*rows, strict=True)]
        assert sum(widths) <= 38, (step.title, widths)
    assert len(tables) > 2
