"""Use of processor and memory, from /proc."""

import math
import os
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple


class Used(NamedTuple):
    """Use of a process with its descendants; nan without /proc.

    Attributes:
        seconds: processor time so far [s].
        memory: shared pages count once [B].
    """

    seconds: float
    memory: float
    processes: int


def used_by_tree(pid: int) -> Used:
    parents: dict[int, int] = {}
    ticks: dict[int, int] = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        # A process may end meanwhile.
        with suppress(OSError):
            fields = path.read_text(encoding="ascii", errors="replace").rsplit(")", 1)[1].split()
            # Its own time, and that of its ended children.
            parents[int(path.parent.name)], ticks[int(path.parent.name)] = (
                int(fields[1]),
                sum(map(int, fields[11:15])),
            )
    tree = [pid]
    for one in tree:
        tree += [child for child, parent in parents.items() if parent == one]
    if pid not in ticks:
        return Used(math.nan, math.nan, 1)
    return Used(
        sum(ticks.get(one, 0) for one in tree) / os.sysconf("SC_CLK_TCK"), sum(map(_memory, tree)), len(tree)
    )


def _memory(pid: int) -> float:
    with suppress(OSError):
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text(encoding="ascii").splitlines()
        return 1024.0 * next((int(line.split()[1]) for line in lines if line.startswith("Pss:")), 0)
    return 0.0
