"""All features, from the top down: each may use those below it; no file of the core imports any."""

from typing import Final

from app.feature import Feature
from app.features.bench import BENCH
from app.features.classroom import CLASSROOM
from app.features.custom_law import CUSTOM_LAW
from app.features.duel import DUEL
from app.features.exports import EXPORTS
from app.features.figures import FIGURES
from app.features.formula_law import FORMULA_LAW
from app.features.handout import HANDOUT
from app.features.jupyter import JUPYTER
from app.features.lab_report import LAB_REPORT
from app.features.league import LEAGUE
from app.features.lecture import LECTURE
from app.features.lessons import LESSONS
from app.features.lever import LEVER
from app.features.marks import MARKS
from app.features.measures import MEASURES
from app.features.person_files import PERSON_FILES
from app.features.robot_files import ROBOT_FILES
from app.features.second_person import SECOND_PERSON
from app.features.store import STORE
from app.features.studies import STUDIES
from app.features.sweep import SWEEP
from app.features.workers import WORKERS
from app.i18n.catalogue import add_catalogues
from app.plots.chart_list import add_charts
from app.text.document_list import add_documents
from scenes.given_robots import add_robot_reader
from scenes.setting_spec import offer_choices

FEATURES: Final[tuple[Feature, ...]] = (
    BENCH,
    JUPYTER,
    LECTURE,
    CLASSROOM,
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
    LEVER,
    FORMULA_LAW,
    CUSTOM_LAW,
    STUDIES,
    SWEEP,
    PERSON_FILES,
    ROBOT_FILES,
    WORKERS,
    STORE,
)

# Every process that uses a feature imports this package first, and with it texts, charts, documents, choices
# and readers of all.
add_catalogues(feature.texts for feature in FEATURES if feature.texts is not None)
add_charts(feature.charts for feature in FEATURES if feature.charts is not None)
add_documents({name: one for feature in FEATURES for name, one in feature.documents.items()})
for feature in FEATURES:
    offer_choices(feature.choices)
    if feature.robot_reader is not None:
        add_robot_reader(feature.robot_reader)
