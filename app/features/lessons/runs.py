"""One run as data, and settings in words."""

import re
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final, Literal

from app.features.measures.room_places import Start
from app.i18n.catalogue import words_of
from app.i18n.speaking import N_, spoken
from app.settings import Language, Settings
from app.text.first_task_texts import in_symbols
from app.text.setting_values import value_text
from controllers.errors import LazyText, joined
from scenes.quantities import DISTANCE, KeptQuantity
from scenes.setting_spec import Spec
from scenes.settings import RunSettings, changed, specs, values

Pairs = tuple[tuple[str, Any], ...]

InputKind = Literal["autopilot", "none", "yours", "script", "file", "kept"]

LONGEST: Final = 60.0
"""Longest run of a step [s]."""


@dataclass(frozen=True)
class Input:
    """Source of the inputs.

    Attributes:
        name: of a script, a file beside the lesson, or a kept motion.
        fallback: used until a motion is kept.
    """

    kind: InputKind
    name: str = ""
    parameters: Pairs = ()
    fallback: "Input | None" = None


AUTOPILOT: Final = Input("autopilot")


@dataclass(frozen=True)
class Setup:
    """One run.

    Attributes:
        changes: settings that differ from the defaults, by key.
        start: None for the scene's own.
        seconds: time of the measurement [s].
    """

    changes: Pairs
    input: Input
    start: Start | None
    seconds: float
    folder: Path

    def settings(self, start: Settings) -> Settings:
        """The lesson's settings; of the page, only those that it changes."""
        settings = replace(start, run=RunSettings())
        for key, value in self.changes:
            settings = changed(settings, key, value)
        return settings

    @cached_property
    def run(self) -> RunSettings:
        # Called in every frame of a lesson.
        return self.settings(Settings()).run

    def with_changes(self, changes: Pairs) -> "Setup":
        return replace(self, changes=tuple((dict(self.changes) | dict(changes)).items()))


def deviations(asked: RunSettings, had: RunSettings) -> Pairs:
    """Settings that differ, except the lever."""
    before, after = values(asked), values(had)
    return tuple((key, value) for key, value in after.items() if before[key] != value and key != "lever")


_SYMBOL: Final = re.compile(r"(?:^|\s)(?:[^\W_]{1,2}|\w_\w+)$")
"""Symbol at the end of a label."""


def changes_text(changes: Pairs) -> LazyText:
    """Settings in words: "n = 2, law set to “Unprotected (task only)”"."""
    return joined([_change_text(key, value) for key, value in changes], ", ")


def _change_text(key: str, value: object) -> LazyText:
    spec: Spec = specs(Settings)[key]
    label, shown = LazyText(spec.label), value_text(key, value)
    if isinstance(value, bool):
        return LazyText(N_("“{label}” switched {value}"), label=label, value=shown)
    if spec.choices or spec.read is not None:
        return LazyText(N_("{label} set to “{value}”"), label=label, value=shown)
    return LazyText(
        "{label} = {value}" if _SYMBOL.search(spec.label) else "{label} {value}", label=label, value=shown
    )


def settings_text(changes: Pairs, language: Language | None = None, quantity: KeptQuantity = DISTANCE) -> str:
    """In the page's language if `language` is None."""
    translate = spoken() if language is None else words_of(language)
    return in_symbols(translate(changes_text(changes)).replace("d_m", "dₘ"), quantity)
