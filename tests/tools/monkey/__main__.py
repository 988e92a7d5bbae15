"""Random actions of a visitor in a real browser: `python -m tests.tools.monkey --seeds 1 2 3 --seconds 60`.

The same seed gives the same actions on the same page; a failure prints the seed and all actions.
"""

from __future__ import annotations

import argparse
import os
import sys

from tests.browser import launch, started_playwright
from tests.tools.monkey.visitor import Trouble, let_loose


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--least", type=int, default=0, help="number of actions at least")
    parser.add_argument("--lecture", action="store_true", help="on the stage of a lecture")
    arguments = parser.parse_args()
    failed = 0
    with started_playwright() as playwright:
        browser = launch(playwright)
        for seed in arguments.seeds:
            try:
                monkey = let_loose(browser, seed, arguments.seconds, arguments.least, arguments.lecture)
                did = ", ".join(f"{count} {name}" for name, count in monkey.counts.most_common())
                print(f"seed {seed}: {len(monkey.done)} actions without trouble ({did})", flush=True)
            except Trouble as trouble:
                failed += 1
                print(f"TROUBLE\n{trouble}\n", flush=True)
        browser.close()
    return failed


if __name__ == "__main__":
    status = main()
    sys.stdout.flush()
    # Background workers may still hold resources.
    os._exit(1 if status else 0)
