"""Make small mistakes in the product and find which of them the tests detect:
`python -m tests.tools.mutants controllers=80 scenes=70 app/features/sweep=50`.

Every mistake is made in a copy of the tree, where the quick tests near the changed module run until one
fails. A mutant that survives shows untested behaviour, or is a change without effect.
"""

import argparse
import json
import math
import sys
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from random import Random
from time import perf_counter

from tests.tools.mutants.near_tests import ImportGraph
from tests.tools.mutants.operators import Change, changed, changes
from tests.tools.mutants.trials import OURS, Copy, Outcome, load_heavy_packages

ROOT = Path(__file__).parents[3]


@dataclass(frozen=True)
class Mutant:
    """A mistake in a file.

    Attributes:
        folder: the folder of its draw.
        file: below the root, with slashes.
        text: of the file with the mistake.
    """

    folder: str
    file: str
    change: Change
    text: str


def draw(root: Path, counts: dict[str, int], seed: int) -> list[Mutant]:
    """Random mutants: every kind of mistake is equally frequent while it has places.

    Args:
        counts: number of mutants for each folder.

    Returns:
        Mutants of all folders in turn: every beginning of the list has the folders in the same proportion.
    """
    placed: list[tuple[float, int, Mutant]] = []
    for number, (folder, count) in enumerate(counts.items()):
        drawn = _drawn(root, folder, Random(f"{seed} {number}"))
        placed += [
            ((turn + 0.5) / count, number, mutant) for turn, mutant in zip(range(count), drawn, strict=False)
        ]
    return [mutant for *_, mutant in sorted(placed, key=lambda one: one[:2])]


def _drawn(root: Path, folder: str, chance: Random) -> Iterator[Mutant]:
    kinds: dict[str, list[tuple[Path, Change]]] = defaultdict(list)
    for path in sorted((root / folder).rglob("*.py")):
        for change in changes(path.read_text(encoding="utf-8")):
            kinds[change.operator].append((path, change))
    for places in kinds.values():
        chance.shuffle(places)
    while there := sorted(kind for kind in kinds if kinds[kind]):
        path, change = kinds[chance.choice(there)].pop()
        text = changed(path.read_text(encoding="utf-8"), change)
        if text is not None:
            yield Mutant(folder, path.relative_to(root).as_posix(), change, text)


def interval(killed: int, all_of_them: int) -> tuple[float, float]:
    """Wilson's 95 % interval of a share."""
    if not all_of_them:
        return 0.0, 1.0
    z, share = 1.96, killed / all_of_them
    middle = share + z**2 / (2 * all_of_them)
    half = z * math.sqrt(share * (1 - share) / all_of_them + z**2 / (4 * all_of_them**2))
    scale = 1 + z**2 / all_of_them
    return max(0.0, (middle - half) / scale), min(1.0, (middle + half) / scale)


def table(verdicts: Sequence[tuple[str, str]]) -> str:
    """Table of killed, survived and slow mutants per folder; the share is killed of killed and survived.

    Args:
        verdicts: folder and verdict of each mutant.
    """
    lines = ["| | killed | survived | slow | killed [%] | 95 % |", "|---|---|---|---|---|---|"]
    for folder in [*dict.fromkeys(folder for folder, _ in verdicts), "all"]:
        found = [verdict for one, verdict in verdicts if folder in (one, "all")]
        killed, survived, slow = (found.count(verdict) for verdict in ("killed", "survived", "slow"))
        low, high = interval(killed, killed + survived)
        share = f"{100 * killed / (killed + survived):.0f}" if killed + survived else "–"
        lines.append(
            f"| {folder} | {killed} | {survived} | {slow} | {share} | {100 * low:.0f}–{100 * high:.0f} |"
        )
    return "\n".join(lines)


def as_json(mutant: Mutant, outcome: Outcome, tests: list[str]) -> dict[str, object]:
    found = asdict(mutant.change) | asdict(outcome) | {"tests": tests}
    return {"folder": mutant.folder, "file": mutant.file, **found}


def _counted(text: str) -> tuple[str, int]:
    folder, _, count = text.partition("=")
    return folder.rstrip("/"), int(count)


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folders", nargs="+", type=_counted, metavar="FOLDER=COUNT")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tree", type=Path, default=ROOT, help="checkout, of this commit or another one")
    parser.add_argument("--limit", type=float, default=60.0, help="time for the tests of a mutant [s]")
    parser.add_argument("--budget", type=float, default=20.0, help="what these tests usually take [s]")
    parser.add_argument("--minutes", type=float, default=math.inf, help="no new mutant after this time")
    parser.add_argument("--json", type=Path, help="file for all mutants with their verdicts")
    chosen = parser.parse_args(arguments)
    mutants = draw(chosen.tree, dict(chosen.folders), chosen.seed)
    graph = ImportGraph(chosen.tree, OURS[:-1])
    load_heavy_packages()
    copy = Copy(chosen.tree, chosen.limit, chosen.budget)
    done: list[dict[str, object]] = []
    verdicts: list[tuple[str, str]] = []
    begin = perf_counter()
    try:
        for mutant in mutants:
            if perf_counter() - begin > 60.0 * chosen.minutes:
                break
            tests = copy.chosen(graph.near(mutant.file))
            outcome = copy.judge(mutant.file, mutant.text, tests)
            done.append(as_json(mutant, outcome, tests))
            verdicts.append((mutant.folder, outcome.verdict))
            place = f"{mutant.file}:{mutant.change.line}"
            print(
                f"{len(done):3d} {outcome.verdict:8s} {outcome.seconds:5.1f} s  {place}  {mutant.change.operator}",
                flush=True,
            )
            if chosen.json:
                chosen.json.write_text(json.dumps(done, indent=1, ensure_ascii=False), encoding="utf-8")
    finally:
        copy.close()
    print(table(verdicts))
    return 0


if __name__ == "__main__":
    sys.exit(main())
