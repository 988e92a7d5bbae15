"""Searches beside one session's run for a run that breaks the promise under the present settings; the worst one can be replayed."""

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
"""Least wall time of a search [s]."""

STARTS: Final = 16
"""Least number of start postures of a search: on a busy machine it lasts longer."""

NAME: Final = LazyText("the worst run found")
"""Name of the replay, in place of a file's name."""


class CounterexampleSearch:
    """The search of one session; all methods belong to the thread that advances it.

    Args:
        background: where the runs are made; None where nothing is searched.
        wake: called, from any thread, when there is news.
        settings: gives the session's present settings.
        watch: has a run replayed, by its name.

    Attributes:
        worst: the worst run so far; None before the first start has been searched.
        runs: how many have been made.
        replayed: the attack that is replayed, or was before.
        message: why nothing can be searched or replayed, for the visitor; "" if all is well.
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
        """Whether a search is under way."""
        return "search" in self._jobs.kinds

    @property
    def broken(self) -> bool:
        """Whether the promise broke in the worst run."""
        return self.worst is not None and self.worst.loss.lost > BROKEN

    def toggle(self) -> None:
        """Begin a search, or end the one under way and keep what it has found."""
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
        """Collect what was found, and go on. `elapsed`: wall time since the last call [s]."""
        self._elapsed += elapsed
        self._jobs.collect()
        if self._asked is not None and self._asked != self._settings().run:
            self.forget()

    def replay_worst(self) -> None:
        """Replay the worst run so far."""
        if self.worst is not None:
            self.replay(self.worst.attack)

    def replay(self, attack: Attack) -> None:
        """Replay an attack."""
        self._jobs.submit("replay", partial(self._show, attack), replayed, attack, urgent=True)

    def open(self, text: str) -> None:
        """Replay the attack that a link names, under the present settings.

        Raises:
            BadSetting: it names none.
        """
        self.replay(attack_of(self._settings().run, text))

    def forget(self) -> None:
        """Drop the search and what it has found."""
        self._jobs.drop("search")
        self._asked = self.worst = None
        self.runs, self.message = 0, ""

    def close(self) -> None:
        """Drop everything that is being computed."""
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
