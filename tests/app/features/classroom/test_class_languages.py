"""Each student reads the poll in his or her language."""

from dataclasses import replace

from app.features.classroom.classroom import Classroom
from app.features.lessons.bookmark import Phase
from app.features.lessons.outcomes import reference
from app.features.lessons.walkthrough import Walkthrough
from app.i18n.speaking import set_language
from app.settings import TRANSLATIONS
from scenes.settings import RunSettings, values
from tests.app.features.lessons.helpers import our_book
from tests.app.features.lessons.test_languages import ENGLISH, phrases


def test_the_class_reads_the_poll_in_its_own_language() -> None:
    walk, room = Walkthrough(our_book()), Classroom(1)
    walk.go("hold")
    walk.choose(0)
    walk.done.outcome = replace(
        reference(walk.step, walk.step.setup), unlike=tuple(values(RunSettings()).items())
    )
    walk.phase = Phase.OBSERVE
    polls = {}
    for language in ("de", "en", "sl"):
        # The texts have the book's language, not that of the page that asks first.
        set_language("sl" if language == "de" else "de")
        polls[language] = room.poll(walk, our_book(language))
    assert polls["de"] is not None and polls["en"] is not None and polls["sl"] is not None
    for language in TRANSLATIONS:
        texts = (
            *polls[language].choices,
            *polls[language].outcome,
            *(v.reply for v in polls[language].verdicts if v),
        )
        for text in texts:
            assert not [phrase for phrase in phrases(text) if ENGLISH.search(phrase)]
    assert any("law set to “Smooth priority (paper)”" in line for line in polls["en"].outcome)
    assert any("Gesetz auf ‚Glatter Vorrang (Artikel)‘ gestellt" in line for line in polls["de"].outcome)
