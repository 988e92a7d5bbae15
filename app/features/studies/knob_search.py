"""Sets a law's knob so that it keeps another law's smallest distance on the recorded inputs."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

from app.features.studies.law_knobs import KnobMatch, match_knob
from app.features.studies.studies import LEAST
from app.runtime.job_pool import Job, Jobs, JobWatch
from app.session.late_law import GHOST
from app.settings import Settings
from controllers.errors import LazyText
from scenes.inputs import Recorded
from scenes.laws import LAWS
from scenes.settings import LawSettings, RunSettings, specs, values

WINDOW: Final = 30.0
"""Recomputed part of the run for each value of the knob [s]."""


class KnobSearch:
    """The search of one session; all methods belong to the thread that advances it.

    Args:
        background: None if no law can be compared.
        wake: called from any thread on a new result.

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
        """Search for the knob of the ghost's law at the run's distance; with a frozen ghost the reverse."""
        self.turned = ()
        settings = self._settings()
        run, ghost = settings.run, settings.page.ghost
        if not self._jobs.computes:
            self.message = LazyText("Laws cannot be compared while a custom law runs.")
        elif ghost in ("off", GHOST, run.law.law):
            self.message = LazyText("First choose another law as the ghost, or freeze these settings.")
        elif recorded is None or recorded.steps < LEAST:
            self.message = LazyText("There is too little to measure yet; let it run for a few seconds.")
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
        spec = specs(LawSettings).get(match.key)
        parts = {
            "law": LazyText(LAWS[match.law].label),
            "wanted": f"{1000.0 * match.wanted:.0f}".replace("-", "−"),
            "reached": f"{1000.0 * match.reached:.0f}".replace("-", "−"),
        }
        if asked is None or asked != self._settings():
            self.message = LazyText("The settings have changed meanwhile; ask again.")
        elif spec is None:
            self.message = LazyText(
                "{law} has no setting for its distance: it comes as near as {reached} mm, the other law {wanted} mm.",
                **parts,
            )
        elif match.value is None:
            self.message = LazyText(
                "No value of {knob} helps: the other law comes as near as {wanted} mm, {law} at best {reached} mm. Change another "
                "setting first, such as d_m.",
                knob=spec.label,
                **parts,
            )
        else:
            if asked.page.ghost != "frozen":
                self._change("ghost", "frozen")
                self._change("law", match.law)
            knob = LAWS[match.law].distance_knob
            assert knob is not None, "what has a value has a knob"
            self.turned = tuple(knob.settings(match.value))
            for key, number in knob.settings(match.value).items():
                self._change(key, number)
            value = f"{spec.page_scale * match.value:.4g} {spec.page_unit}".rstrip()
            self.message = LazyText(
                "{law} with {knob} = {value} comes as near as {reached} mm, the ghost’s law {wanted} mm.",
                knob=spec.label,
                value=value,
                **parts,
            )

    def _failed(self, job: Job) -> None:
        self._asked, self.message = None, job.message


def _overrides(run: RunSettings) -> dict[str, object]:
    """Key → value of a frozen ghost: law, gain and hardware."""
    return {**values(run.law), **values(run.hardware), "k": run.gain}
