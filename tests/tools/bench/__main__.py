"""Benchmarks for developers: `python -m tests.tools.bench peers`, `capacity`, `fairness` or `waits`; each with `--help`.

They print a table; `--out` saves the figures as JSON, `--compare` prints ratios to saved figures.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from app.features.bench.figures_table import BenchRows, printed, ratio_table, read_figures, save_figures
from controllers.errors import DuetError


def _peers(chosen: argparse.Namespace) -> dict[str, Any]:
    from tests.tools.bench.peers import measure_peers, peers_table

    result = measure_peers(chosen.steps)
    print(peers_table(result))
    return result


def printed_with_limits(rows: BenchRows) -> dict[str, Any]:
    """Print rows, and the parts of the server's time if measured; return the figures for JSON."""
    from tests.tools.bench.processes import limit_of

    result = printed(rows)
    for name, row in result["figures"].items():
        if limit := limit_of(row):
            print(f"{name:36s} {limit}")
    return result


def _capacity(chosen: argparse.Namespace) -> dict[str, Any]:
    from tests.tools.bench.crowds import measure_capacity, measure_crowds

    seconds = chosen.seconds
    return printed_with_limits(
        measure_capacity(chosen.sessions, seconds) if chosen.sessions else measure_crowds(seconds)
    )


def _fairness(chosen: argparse.Namespace) -> dict[str, Any]:
    from tests.tools.bench.fairness import measure_fairness

    return printed(measure_fairness(chosen.seconds))


def _waits(_: argparse.Namespace) -> dict[str, Any]:
    from tests.tools.bench.waits import measure_waits

    return printed(measure_waits())


def _at_least_one(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError("must be at least 1")
    return number


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tests.tools.bench", description="Benchmarks for developers."
    )
    kinds = parser.add_subparsers(required=True, metavar="peers|capacity|fairness|waits")
    peers = kinds.add_parser(
        "peers",
        help="the hold experiment in pink, mink, embodik and roboplan too, interleaved (needs the extra `peers`)",
    )
    peers.set_defaults(measure=_peers)
    peers.add_argument("--steps", type=_at_least_one, default=9200, help="steps of each method")
    capacity = kinds.add_parser(
        "capacity",
        help="a lecture with 30 watchers and 8 private sessions, with the parts of the server's time",
    )
    capacity.set_defaults(measure=_capacity)
    capacity.add_argument(
        "--sessions",
        type=_at_least_one,
        nargs="+",
        default=[],
        metavar="N",
        help="instead, CPU, memory and the slowest visitor's frames of `lwr-duet serve` with N private sessions, "
        "such as 8 16 30 60",
    )
    capacity.add_argument("--seconds", type=float, default=10.0, help="duration of each row [s]")
    fairness = kinds.add_parser(
        "fairness",
        help="what a visitor's page has left while another floods the server, sends heavy messages, or comes with a class",
    )
    fairness.set_defaults(measure=_fairness)
    fairness.add_argument(
        "--seconds", type=float, default=2.0, help="duration of each row [s]; 2 ends within two minutes"
    )
    waits = kinds.add_parser(
        "waits", help='how long a run takes at the command line, and the curves of "what if"'
    )
    waits.set_defaults(measure=_waits)
    for kind in (peers, capacity, fairness, waits):
        kind.add_argument("--out", type=Path, help="save the figures to this JSON file")
        kind.add_argument("--compare", type=Path, help="print ratios to the figures in this JSON file")
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print and save. Returns 0, or 2 after an error in one line on stderr."""
    chosen = _parser().parse_args(arguments)
    try:
        before = read_figures(chosen.compare) if chosen.compare else None
        result = chosen.measure(chosen)
        if before is not None:
            print(ratio_table(result, before))
        if chosen.out is not None:
            save_figures(result, chosen.out)
    except DuetError as error:
        print(f"bench: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
