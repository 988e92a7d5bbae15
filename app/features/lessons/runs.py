"""One run as data: who stands where, who moves, for how long; and settings as a person reads them."""

import re
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final, Literal

from app.features.measures.room_places import Start
from app.i18n.catalogue import words_of
from app.i18n.speaking import N_, spoken
from app.settings import Language, Settings
from app.text.setting_values import value_text
from controllers.errors import LazyText, joined
from scenes.setting_spec import Spec
from scenes.settings import RunSettings, changed, specs, values

Pairs = tuple[tuple[str, Any], ...]
"""Key and value, in order: a dictionary that can be compared and hashed."""

InputKind = Literal["autopilot", "none", "yours", "script", "file", "kept"]
"""Who moves what can be moved: the experiment's own seeded person, none, the student, a script, a recorded file, or what the student
did in an earlier step."""

LONGEST: Final = 60.0
"""Longest run of a step [s]."""


@dataclass(frozen=True)
class Input:
    """Who moves what can be moved.

    Attributes:
        kind: see `InputKind`.
        name: of a script, of a file beside the lesson, or of what was kept.
        parameters: of a script.
        fallback: who moves as long as nothing was kept under that name.
    """

    kind: InputKind
    name: str = ""
    parameters: Pairs = ()
    fallback: "Input | None" = None


AUTOPILOT: Final = Input("autopilot")


@dataclass(frozen=True)
class Setup:
    """One run: everything that decides how it goes.

    Attributes:
        changes: settings by key that are not as they are at first, of the run and of the page.
        start: where everything begins; None for the room's start.
        seconds: after which the outcome is measured [s].
        folder: where its files are.
    """

    changes: Pairs
    input: Input
    start: Start | None
    seconds: float
    folder: Path

    def settings(self, start: Settings) -> Settings:
        """Return these settings: the run wholly the lesson's, the page as it was but for what the lesson says."""
        settings = replace(start, run=RunSettings())
        for key, value in self.changes:
            settings = changed(settings, key, value)
        return settings

    @cached_property
    def run(self) -> RunSettings:
        # Asked for in every frame of a lesson.
        return self.settings(Settings()).run

    def with_changes(self, changes: Pairs) -> "Setup":
        return replace(self, changes=tuple((dict(self.changes) | dict(changes)).items()))


def deviations(asked: RunSettings, had: RunSettings) -> Pairs:
    """Return the settings of a run, by key, that differ from those asked for; a lever is there to be moved."""
    before, after = values(asked), values(had)
    return tuple((key, value) for key, value in after.items() if before[key] != value and key != "lever")


_SYMBOL: Final = re.compile(r"(?:^|\s)(?:[^\W_]{1,2}|\w_\w+)$")
"""The end of a label that a number can be equal to: "n", "dt", "d_m", "dead time T"."""


def changes_text(changes: Pairs) -> LazyText:
    """Return settings as they are named on the page, for a sentence: "n = 2, dt = 5 ms, law set to “Unprotected (task only)”"."""
    return joined([_change_text(key, value) for key, value in changes], ", ")


def _change_text(key: str, value: object) -> LazyText:
    spec: Spec = specs(Settings)[key]
    label, shown = LazyText(spec.label), value_text(key, value)
    if isinstance(value, bool):
        return LazyText(N_("“{label}” switched {value}"), label=label, value=shown)
    if spec.choices or spec.read is not None:
        return LazyText(N_("{label} set to “{value}”"), label=label, value=shown)
    return LazyText("{label} = {value}" if _SYMBOL.search(spec.label) else "{label} {value}", label=label, value=shown)


def settings_text(changes: Pairs, language: Language | None = None) -> str:
    """Return settings as a person reads them, in a language; None for that of the page."""
    translate = spoken() if language is None else words_of(language)
    return translate(changes_text(changes)).replace("d_m", "dₘ")
