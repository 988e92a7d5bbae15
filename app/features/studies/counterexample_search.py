"""Background search for a counterexample."""

from collections.abc import Callable
from functools import partial
from math import inf
from typing import Final

from app.features.studies.counterexample import BROKEN, Attack, Found, attack_of, check, replayed, searched
from app.runtime.job_pool import Job, Jobs, JobWatch
from app.settings import Settings
from controllers.errors import BadSetting, LazyText
from scenes.inputs import Recorded
from scenes.settings import RunSettings

SECONDS: Final = 20.0
"""Shortest wall time of a search [s]."""

STARTS: Final = 16
"""Fewest start postures, however long they take."""

NAME: Final = LazyText("the worst run found")


class CounterexampleSearch:
    """All methods belong to the thread that advances the session.

    Args:
        background, wake: see `JobWatch`.

    Attributes:
        message: reason of a failure, for the visitor, or "".
    """

    def __init__(
        self,
        background: Jobs | None,
        wake: Callable[[], None],
        settings: Callable[[], Settings],
        watch: Callable[[Recorded, str], None],
    ) -> None:
        self._jobs = JobWatch(background, wake, self._failed)
        self._settings, self._watch = settings, watch
        self._asked: RunSettings | None = None
        self._starts, self._elapsed = 0, 0.0
        self.worst: Found | None = None
        self.runs = 0
        self.replayed: Attack | None = None
        self.message = ""

    @property
    def busy(self) -> bool:
        return "search" in self._jobs.kinds

    @property
    def broken(self) -> bool:
        return self.worst is not None and self.worst.loss.lost > BROKEN

    def toggle(self) -> None:
        if self.busy:
            self._jobs.drop("search")
            return
        self.forget()
        run = self._settings().run
        if not self._jobs.computes:
            self.message = LazyText("Nothing can be searched while a custom law runs.")
            return
        try:
            check(run)
        except BadSetting as error:
            self.message = str(error)
            return
        self._asked, self._starts, self._elapsed = run, 0, 0.0
        self._search_on()

    def advance(self, elapsed: float) -> None:
        """Collect results, and continue. `elapsed`: wall time [s]."""
        self._elapsed += elapsed
        self._jobs.collect()
        if self._asked is not None and self._asked != self._settings().run:
            self.forget()

    def replay_worst(self) -> None:
        if self.worst is not None:
            self.replay(self.worst.attack)

    def replay(self, attack: Attack) -> None:
        self._jobs.submit("replay", partial(self._show, attack), replayed, attack, urgent=True)

    def open(self, text: str) -> None:
        """Replay a link's attack under the current settings.

        Raises:
            BadSetting: invalid text.
        """
        self.replay(attack_of(self._settings().run, text))

    def forget(self) -> None:
        self._jobs.drop("search")
        self._asked = self.worst = None
        self.runs, self.message = 0, ""

    def close(self) -> None:
        self._jobs.close()

    def _show(self, attack: Attack, recorded: Recorded) -> None:
        self.replayed = attack
        self._watch(recorded, NAME)

    def _search_on(self) -> None:
        assert self._asked is not None
        self._jobs.submit("search", self._take, searched, self._asked, self._asked.seed, self._starts, inf)
        self._starts += 1

    def _take(self, found: Found) -> None:
        self.runs += found.runs
        if self.worst is None or found.badness > self.worst.badness:
            self.worst = found
        if self._elapsed < SECONDS or self._starts < STARTS:
            self._search_on()

    def _failed(self, job: Job) -> None:
        self.message = job.message
