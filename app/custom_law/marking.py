"""The process that puts one file through the six tests: `python -m app.custom_law.marking LIMITS NAME LEVEL`; see `marked`.

It reads the file from its standard input, and writes one line of JSON for the kind of isolation and for each verdict.
"""

import json
import sys
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

from app.custom_law.examine import verdicts
from app.custom_law.isolation import guard_memory
from app.custom_law.law_limits import LawLimits


def main() -> None:
    """Make the tests."""
    limits, name, level = sys.argv[1:]
    guard_memory()
    text = sys.stdin.buffer.read()
    _write({"isolation": level})
    for verdict in verdicts(Path(name), LawLimits(**json.loads(limits)), text=text):
        _write(asdict(verdict) | {"reason": str(verdict.reason)})


def _write(line: Mapping[str, object]) -> None:
    print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main()
