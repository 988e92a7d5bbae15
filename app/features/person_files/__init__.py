from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.feature import Feature
from app.i18n.speaking import N_

if TYPE_CHECKING:
    from app.features.person_files.person_options import PersonOptions, PersonRunSource
    from app.hosting.opened_feature import OpenedFeature
    from app.hosting.serve_options import ServeOptions


def _options() -> "type[PersonOptions]":
    from app.features.person_files.person_options import PersonOptions

    return PersonOptions


def _run_source() -> "type[PersonRunSource]":
    from app.features.person_files.person_options import PersonRunSource

    return PersonRunSource


def _opened(options: "ServeOptions") -> "OpenedFeature":
    from app.features.person_files.opened_persons import open_persons

    return open_persons(options.of(_options()))


_CHOICES: Final = {"source": {"file": N_("A BVH file"), "camera": N_("A camera at the server")}}

PERSON_FILES: Final = Feature(
    "person_files",
    texts=Path(__file__).parent,
    choices=_CHOICES,
    options=_options,
    run_source=_run_source,
    opened=_opened,
)
