"""Search for the knob value at which a law keeps another's distance."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

from app.features.studies.law_knobs import KnobMatch, match_knob
from app.features.studies.studies import LEAST
from app.features.studies.value_texts import AS_NEAR, NO_SETTING, NO_VALUE, OF_A_STUDIED_VALUE
from app.runtime.job_pool import Job, Jobs, JobWatch
from app.session.late_law import GHOST
from app.settings import Settings
from app.text.first_task_texts import in_unit, wording
from controllers.errors import LazyText
from scenes.inputs import Recorded
from scenes.laws import LAWS
from scenes.settings import LawSettings, RunSettings, specs, values

WINDOW: Final = 30.0
"""Part of the run recomputed for each value [s]."""


class KnobSearch:
    """All methods belong to the thread that advances the session.

    Args:
        background, wake: see `JobWatch`.

    Attributes:
        message: result or reason, for the visitor; "" before the first search.
    """

    def __init__(
        self,
        background: Jobs | None,
        wake: Callable[[], None],
        settings: Callable[[], Settings],
        change: Callable[[str, object], None],
    ) -> None:
        self._jobs = JobWatch(background, wake, self._failed)
        self._settings, self._change = settings, change
        self.message = ""
        self.turned: tuple[str, ...] = ()
        self._asked: Settings | None = None

    @property
    def busy(self) -> bool:
        return self._asked is not None

    def ask(self, frozen: RunSettings, recorded: Recorded | None) -> None:
        """Fit the ghost's law to the run's distance; with a frozen ghost the reverse."""
        self.turned = ()
        settings = self._settings()
        run, ghost = settings.run, settings.page.ghost
        if not self._jobs.computes:
            self.message = LazyText("Laws cannot be compared while a custom law runs.")
        elif ghost in ("off", GHOST, run.law.law):
            self.message = LazyText("First choose another law as the ghost, or freeze these settings.")
        elif recorded is None or recorded.steps < LEAST:
            self.message = LazyText("There is too little to measure yet; run it for a few seconds.")
        else:
            reference = frozen if ghost == "frozen" else run
            chosen = run if ghost == "frozen" else replace(run, law=replace(run.law, law=ghost))
            self._asked, self.message = settings, ""
            self._jobs.submit(
                "knob", self._found, match_knob, recorded, _overrides(reference), _overrides(chosen)
            )

    def advance(self) -> None:
        self._jobs.collect()

    def forget(self) -> None:
        self._jobs.close()
        self._asked, self.message, self.turned = None, "", ()

    def _found(self, match: KnobMatch) -> None:
        asked, self._asked = self._asked, None
        spec, kept = specs(LawSettings).get(match.key), self._settings().run.quantity
        parts = {
            "law": LazyText(LAWS[match.law].label),
            "wanted": f"{1000.0 * match.wanted:.0f}".replace("-", "−"),
            "reached": f"{1000.0 * match.reached:.0f}".replace("-", "−"),
        }
        if asked is None or asked != self._settings():
            self.message = LazyText("The settings have changed since then; ask again.")
        elif spec is None:
            self.message = LazyText(wording(NO_SETTING, kept, OF_A_STUDIED_VALUE), **parts)
        elif match.value is None:
            self.message = LazyText(wording(NO_VALUE, kept, OF_A_STUDIED_VALUE), knob=spec.label, **parts)
        else:
            if asked.page.ghost != "frozen":
                self._change("ghost", "frozen")
                self._change("law", match.law)
            knob = LAWS[match.law].distance_knob
            assert knob is not None, "what has a value has a knob"
            self.turned = tuple(knob.settings(match.value))
            for key, number in knob.settings(match.value).items():
                self._change(key, number)
            # Units of d and v are said with the whole text.
            unit = in_unit(spec, kept).page_unit if spec.key == "eta" else spec.page_unit
            value = f"{spec.page_scale * match.value:.4g} {unit}".rstrip()
            self.message = LazyText(
                wording(AS_NEAR, kept, OF_A_STUDIED_VALUE), knob=spec.label, value=value, **parts
            )

    def _failed(self, job: Job) -> None:
        self._asked, self.message = None, job.message


def _overrides(run: RunSettings) -> dict[str, object]:
    return {**values(run.law), **values(run.hardware), "k": run.gain}
