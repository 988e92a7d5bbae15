"""The six tests on a file."""

from pathlib import Path

from app.own_law.limits import Limits
from app.own_law.own_law import OwnLaw
from app.own_law.trials import TRIALS, examine_law
from app.own_law.verdict import Verdict


def examine(path: Path, limits: Limits = Limits()) -> list[Verdict]:  # noqa: B008 (frozen)
    """Return the verdicts of all six tests on a file; a law that fails in one of them begins the next one anew.

    Raises:
        BadInputFile: there is no such file, or it cannot be read.
    """
    with OwnLaw(path, limits, waits=True) as law:

        def again() -> None:
            if law.problem is not None:
                law.problem = None
                law.restart()

        if not law.load():
            # It cannot even be loaded: one reason for all.
            reason = law.problem.text if law.problem is not None else "the file could not be loaded."
            return [Verdict(name, False, reason, {}) for name in TRIALS]
        return examine_law(law, again)


def verdict_table(path: Path, verdicts: list[Verdict]) -> str:
    """Return the verdicts as text: one line a test, and how many passed."""
    width = max(len(verdict.name) for verdict in verdicts)
    lines = [f"{'pass' if v.passed else 'FAIL'}  {v.name:{width}}  {v.reason}" for v in verdicts]
    passed = sum(v.passed for v in verdicts)
    return "\n".join([*lines, f"{path.name}: {passed} of {len(verdicts)} tests passed."])
