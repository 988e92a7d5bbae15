"""All features, from the top down: each may use those below it, and the core; no file of the core imports any of them."""

from typing import Final

from app.feature import Feature
from app.features.bench import BENCH
from app.features.duel import DUEL
from app.features.exports import EXPORTS
from app.features.figures import FIGURES
from app.features.handout import HANDOUT
from app.features.jupyter import JUPYTER
from app.features.lab_report import LAB_REPORT
from app.features.league import LEAGUE
from app.features.lecture import LECTURE
from app.features.lessons import LESSONS
from app.features.marks import MARKS
from app.features.measures import MEASURES
from app.features.second_person import SECOND_PERSON
from app.features.sweep import SWEEP
from app.i18n.catalogue import add_catalogues
from app.text.document_list import add_documents

FEATURES: Final[tuple[Feature, ...]] = (
    BENCH,
    JUPYTER,
    LECTURE,
    LEAGUE,
    MARKS,
    DUEL,
    HANDOUT,
    LAB_REPORT,
    LESSONS,
    MEASURES,
    EXPORTS,
    FIGURES,
    SECOND_PERSON,
    SWEEP,
)

# Every process that uses a feature imports this package first, and with it the texts and documents of all of them.
add_catalogues(feature.texts for feature in FEATURES if feature.texts is not None)
add_documents({name: one for feature in FEATURES for name, one in feature.documents.items()})
