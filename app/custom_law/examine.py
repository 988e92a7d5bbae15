"""The six tests on a file."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from app.custom_law import trials
from app.custom_law.custom_law import CustomLaw
from app.custom_law.law_limits import LawLimits
from app.custom_law.trial_result import TrialResult
from app.custom_law.trials import examine_law
from controllers.errors import DuetError
from controllers.kinematics import Array
from controllers.laws.situation import Situation
from scenes.files import readable


class Dropped(DuetError):
    """The tests were given up."""


def examine(
    path: Path,
    limits: LawLimits = LawLimits(),  # noqa: B008 (frozen)
    only: Sequence[str] | None = None,
    text: bytes | None = None,
    stopped: Callable[[], bool] = lambda: False,
) -> list[TrialResult]:
    """Return the verdicts of the tests on a file; a law that fails in one of them is restarted for the next one.

    Args:
        only: names of the tests to be made; None for all six.
        text: the file as it is to be tested, whatever it holds by now; None for what it holds.
        stopped: asked before every call whether to give up.

    Raises:
        BadInputFile: there is no such file, or it cannot be read.
        Dropped: it was `stopped`.
    """
    return list(verdicts(path, limits, only, text, stopped))


def verdicts(
    path: Path,
    limits: LawLimits = LawLimits(),  # noqa: B008 (frozen)
    only: Sequence[str] | None = None,
    text: bytes | None = None,
    stopped: Callable[[], bool] = lambda: False,
) -> Iterator[TrialResult]:
    """Yield each verdict as soon as it is known; see `examine`."""
    with _Examined(path, limits, text, stopped) as law:

        def again() -> None:
            if law.problem is not None:
                law.problem = None
                law.restart()

        if not law.load():
            # It cannot even be loaded: one reason for all.
            reason = law.problem.text if law.problem is not None else "the file could not be loaded."
            yield from (TrialResult(name, False, reason, {}) for name in only or trials.TRIALS)
            return
        for name in only or trials.TRIALS:
            yield from examine_law(law, again, (name,))


def examine_one(path: Path, text: bytes, name: str, stopped: Callable[[], bool]) -> TrialResult:
    """Return the verdict of one test on a file; see `examine`. For a process of its own."""
    return examine(path, only=(name,), text=text, stopped=stopped)[0]


class _Examined(CustomLaw):
    """A law that waits to be loaded, and stops on request."""

    def __init__(self, path: Path, limits: LawLimits, text: bytes | None, stopped: Callable[[], bool]) -> None:
        super().__init__(path, limits, waits=True, text=text)
        self._stopped = stopped

    def __call__(self, situation: Situation) -> Array:
        if self._stopped():
            raise Dropped("The tests were given up.")
        return super().__call__(situation)


def verdict_table(path: Path, verdicts: list[TrialResult]) -> str:
    """Return the verdicts as text: one line a test, and how many passed."""
    width = max(len(verdict.name) for verdict in verdicts)
    lines = [f"{'pass' if v.passed else 'FAIL'}  {v.name:{width}}  {v.reason}" for v in verdicts]
    passed = sum(v.passed for v in verdicts)
    return "\n".join([*lines, f"{readable(path.name)}: {passed} of {len(verdicts)} tests passed."])
