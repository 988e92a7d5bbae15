from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.feature import Command, Feature
from app.i18n.speaking import N_

if TYPE_CHECKING:
    from app.features.custom_law.command_options import CustomLawOptions, RunLawOptions
    from app.hosting.opened_feature import OpenedFeature
    from app.hosting.serve_options import ServeOptions
    from app.web.pages import PageAssets

_HERE: Final = Path(__file__).parent


# Value of `app.session.late_law.GHOST`, not imported here, to keep the command line fast.
_CHOICES: Final = {"ghost": {"own": N_("My own law (file or formula)")}}


def _commands() -> Mapping[str, Command]:
    from app.features.custom_law.commands import LawTest, NewLaw, law_test, new_law

    return {"new-law": Command(NewLaw, new_law, "teach"), "law-test": Command(LawTest, law_test, "teach")}


def _options() -> "type[CustomLawOptions]":
    from app.features.custom_law.command_options import CustomLawOptions

    return CustomLawOptions


def _run_source() -> "type[RunLawOptions]":
    from app.features.custom_law.command_options import RunLawOptions

    return RunLawOptions


def _opened(options: "ServeOptions") -> "OpenedFeature":
    from app.features.custom_law.opened_law import OpenedLaw

    return OpenedLaw(options.of(_options()))


def _assets() -> "PageAssets":
    from app.web.pages import PageAssets

    return PageAssets((_HERE / "law_editor.js",), (_HERE / "law_editor.css",))


CUSTOM_LAW: Final = Feature(
    "custom_law",
    texts=_HERE,
    choices=_CHOICES,
    commands=_commands,
    assets=_assets,
    options=_options,
    run_source=_run_source,
    opened=_opened,
)
