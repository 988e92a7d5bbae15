"""Runs of near tests on a copy of a tree, each in a forked process with imported heavy packages."""

import importlib.util
import json
import os
import select
import shutil
import signal
import sys
import tempfile
import traceback
from contextlib import suppress
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from time import perf_counter
from typing import Final

import hypothesis
import pytest

HEAVY: Final = (
    *("numpy", "scipy.optimize", "scipy.spatial", "pinocchio", "coal", "numba", "matplotlib.figure"),
    *("viser", "trimesh", "yourdfpy", "websockets", "msgspec"),
)
"""Packages imported once for all runs, if installed."""

OURS: Final = ("controllers", "scenes", "app", "tests")
LEFT_OUT: Final = shutil.ignore_patterns(
    ".git", ".venv", "__pycache__", ".artifacts", ".hypothesis", ".pytest_cache", "node_modules"
)
SLOW_TEST: Final = 5.0
SLOW_FILE: Final = 15.0
"""Longest test, and longest file [s]; slower ones are left out."""
MOST_FILES: Final = 12


def load_heavy_packages() -> None:
    """Import the common packages before a fork."""
    for name in ("OMP", "OPENBLAS"):
        os.environ.setdefault(f"{name}_NUM_THREADS", "1")
    for name in HEAVY:
        with suppress(ImportError):
            import_module(name)


@dataclass
class Timed:
    """A test file on the unchanged tree.

    Attributes:
        seconds: of the remaining tests.
        left_out: slow or failing tests.
    """

    seconds: float = 0.0
    left_out: set[str] = field(default_factory=set)


@dataclass(frozen=True)
class Outcome:
    """Verdict of the tests on a mutant.

    Attributes:
        verdict: "killed", "survived" or "slow".
        by: first failed test, or the reason of the run's end.
    """

    verdict: str
    by: str
    seconds: float


class Copy:
    """A copy of a tree in the temporary folder, for mutants and their tests.

    Args:
        tree: a checkout.
        limit: time limit of a run [s].
        budget: total time of a mutant's tests on the unchanged tree [s].
    """

    def __init__(self, tree: Path, limit: float, budget: float) -> None:
        self._place = Path(tempfile.mkdtemp(prefix="duet-mutants-"))
        self.root = self._place / "tree"
        self._limit, self._budget = limit, budget
        self._timed: dict[str, Timed] = {}
        shutil.copytree(tree, self.root, ignore=LEFT_OUT)
        (self._place / "warm").mkdir()

    def close(self) -> None:
        shutil.rmtree(self._place, ignore_errors=True)

    def chosen(self, near: list[str]) -> list[str]:
        """The near test files that are quick and pass, within the budget."""
        near = near[:MOST_FILES]
        for file in near:
            if file not in self._timed:
                self._timed[file] = self._time(file)
        chosen: list[str] = []
        left = self._budget
        for file in near:
            seconds = self._timed[file].seconds
            if 0.0 < seconds <= min(left, SLOW_FILE):
                chosen.append(file)
                left -= seconds
        return chosen

    def judge(self, file: str, mutated: str, tests: list[str]) -> Outcome:
        """Run tests on the copy with one file replaced, up to the first failure.

        Args:
            file: below the root.
            mutated: its temporary text.
            tests: files from `chosen`.
        """
        if not tests:
            return Outcome("survived", "no test is near", 0.0)
        path = self.root / file
        original = path.read_bytes()
        machine_code = set(self.root.glob("controllers/__pycache__/loops-*"))
        left_out = set[str]().union(*(self._timed[test].left_out for test in tests))
        try:
            self._write(path, mutated.encode())
            status, seconds, reports = self._run(tests, left_out, stop=True)
        finally:
            self._write(path, original)
            for folder in set(self.root.glob("controllers/__pycache__/loops-*")) - machine_code:
                shutil.rmtree(folder, ignore_errors=True)
        if status is None:
            return Outcome("slow", f"more than {self._limit:.0f} s", seconds)
        if status == pytest.ExitCode.OK:
            return Outcome("survived", "", seconds)
        failed = [name for name, _, outcome, _ in reports if outcome == "failed"]
        return Outcome("killed", failed[0] if failed else f"exit status {status}", seconds)

    def _time(self, file: str) -> Timed:
        status, _, reports = self._run([file], set(), stop=False)
        timed = Timed()
        failed = {name for name, _, outcome, _ in reports if outcome == "failed"}
        if status is None or file in failed:
            return timed
        long = {name for name, when, _, seconds in reports if when == "call" and seconds > SLOW_TEST}
        timed.left_out = failed | long
        timed.seconds = sum(seconds for name, _, _, seconds in reports if name not in timed.left_out)
        return timed

    def _write(self, path: Path, text: bytes) -> None:
        """Write a source and remove its byte code, which would be valid for a text of the same length."""
        path.write_bytes(text)
        Path(importlib.util.cache_from_source(str(path))).unlink(missing_ok=True)

    def _run(
        self, tests: list[str], left_out: set[str], stop: bool
    ) -> tuple[int | None, float, list[tuple[str, str, str, float]]]:
        """Exit status (None after the limit), time, and per part of a test: name, part, outcome and time."""
        reports, warm, cache = self._place / "reports", self._place / "warm", self._place / "cache"
        reports.write_text("", encoding="utf-8")
        if stop:
            shutil.rmtree(cache, ignore_errors=True)
            shutil.copytree(warm, cache)
        begin = perf_counter()
        child = os.fork()
        if child == 0:
            _be_the_run(self.root, cache if stop else warm, tests, Recorder(reports, left_out), stop)
        ready = os.pidfd_open(child)
        ended = bool(select.select([ready], [], [], self._limit)[0])
        os.close(ready)
        with suppress(ProcessLookupError):
            os.killpg(child, signal.SIGKILL)
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        seconds = perf_counter() - begin
        lines = reports.read_text(encoding="utf-8").splitlines()
        return (status if ended else None), seconds, [tuple(json.loads(line)) for line in lines]


def _be_the_run(root: Path, cache: Path, tests: list[str], recorder: "Recorder", stop: bool) -> None:
    """Run pytest on the tree in this process, and exit with its status."""
    status = 70
    try:
        os.setsid()
        output = os.open(root.parent / "output", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        for stream in (1, 2):
            os.dup2(output, stream)
        os.chdir(root)
        for name in [name for name in sys.modules if name.split(".")[0] in OURS]:
            del sys.modules[name]
        sys.path[:] = [
            str(root),
            *(place for place in sys.path if not (Path(place) / "controllers").is_dir()),
        ]
        os.environ |= {"PYTHONPATH": str(root), "XDG_CACHE_HOME": str(cache)}
        options = ["-q", "-p", "no:xdist", "-p", "no:cacheprovider", "--tb=line", "-o", "addopts="]
        options += ["-m", "not slow and not thorough", f"--basetemp={root.parent / 'temporary'}"]
        # The heavy packages were imported before pytest could rewrite their assertions.
        options += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]
        options += ["-x"] if stop else []
        status = int(pytest.main([*options, *tests], plugins=[recorder]))
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


class Recorder:
    """pytest plugin: leaves out tests, does not shrink examples, and records each outcome.

    Args:
        place: file for the outcomes, a line of JSON per part of a test.
        left_out: names of omitted tests.
    """

    def __init__(self, place: Path, left_out: set[str]) -> None:
        self._place, self._left_out = place, left_out

    @pytest.hookimpl(trylast=True)
    def pytest_configure(self) -> None:
        phases = (hypothesis.Phase.explicit, hypothesis.Phase.generate)
        hypothesis.settings.register_profile("mutants", hypothesis.settings(), phases=phases)
        hypothesis.settings.load_profile("mutants")

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        items[:] = [item for item in items if item.nodeid not in self._left_out]

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            self._note(report.nodeid, "collect", report.outcome, 0.0)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self._note(report.nodeid, report.when or "", report.outcome, report.duration)

    def _note(self, name: str, when: str, outcome: str, seconds: float) -> None:
        with self._place.open("a", encoding="utf-8") as file:
            print(json.dumps([name, when, outcome, seconds]), file=file)
