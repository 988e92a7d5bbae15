"""Settings of all tests: one thread for linear algebra (two cores, repeatable timing), same examples."""

import os
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

# Without byte code every process of a test would compile the product again.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
for _library in ("OMP", "OPENBLAS", "MKL", "VECLIB_MAXIMUM", "NUMEXPR"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

import pytest  # noqa: E402
from hypothesis import HealthCheck, settings  # noqa: E402
from xdist.scheduler import LoadScopeScheduling  # noqa: E402

from controllers.system_libraries import MissingLibrary  # noqa: E402
from tests.system_packages import import_pinocchio, with_libraries  # noqa: E402

try:
    with_libraries(import_pinocchio)
except MissingLibrary as _missing:
    # pytest would show any other exception with its traceback.
    sys.exit(f"The tests cannot run: {_missing}")

from scenes.given_robots import GIVEN  # noqa: E402
from scenes.setting_spec import added_choices  # noqa: E402
from tests.approved import approve, pytest_addoption  # noqa: E402
from tests.browser import FAILED, browser, browser_in  # noqa: E402
from tests.tabs import judge_lasting_tabs, lasting_page_at, lasting_tabs, page_at, used_tabs  # noqa: E402

__all__ = [
    "approve",
    "browser",
    "browser_in",
    "judge_lasting_tabs",
    "lasting_page_at",
    "lasting_tabs",
    "page_at",
    "pytest_addoption",
    "used_tabs",
]

settings.register_profile(
    "ci", derandomize=True, deadline=None, print_blob=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("explore", deadline=None, max_examples=1000, print_blob=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))


SLOW = {"browser", "house", "lasting_house", "serve", "folder", "jupyter"}
"""Slow fixtures: a browser, a page's server, the paper's figures, a notebook's server."""


BEGUN = pytest.StashKey[bool]()


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Lower the priority of workers without browser tests: the worker with them needs the most time."""
    session = item.session
    if BEGUN not in session.stash:
        session.stash[BEGUN] = True
        if hasattr(item.config, "workerinput") and hasattr(os, "nice") and not _draws(item.path):
            os.nice(3)


@pytest.fixture(scope="session", autouse=True)
def _own_store(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Keep tests away from the store of this machine's server."""
    os.environ["XDG_STATE_HOME"] = str(tmp_path_factory.mktemp("state"))


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark slow tests and run them first, so that no worker ends alone with them."""
    for item in items:
        fixtures = SLOW & set(item.fixturenames) if isinstance(item, pytest.Function) else set()
        if fixtures or "thorough" in item.keywords:
            item.add_marker("slow")
    items.sort(key=lambda item: (not _draws(item.path), "slow" not in item.keywords))


class OneBrowser(LoadScopeScheduling):
    """Workers share tests by file. All browser files are one unit, as two browsers would slow each other.

    So are the files on figures, which are drawn once for all.
    """

    def _split_scope(self, nodeid: str) -> str:
        file = nodeid.split("::", 1)[0]
        if _draws(self.config.rootpath / file):
            return "browser"
        return "figures" if "/figures/" in file else file


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> OneBrowser:
    config.option.loadscopereorder = False
    return OneBrowser(config, log)  # type: ignore[arg-type]


@cache
def _draws(path: Path) -> bool:
    text = path.read_text(encoding="utf-8")
    return any(word in text for word in ("PageAt", "browser: Browser", "SharedPage", ": Tabs"))


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]):
    """Store the outcome on the test, so that its tabs know if a picture is needed."""
    outcome = yield
    report = outcome.get_result()
    if report.when == "call":
        item.stash[FAILED] = report.failed


@pytest.fixture
def registry() -> Iterator[None]:
    """Remove a test's robots and bases after it."""
    files, added = dict(GIVEN), {key: dict(found) for key, found in added_choices().items()}
    yield
    GIVEN.clear()
    GIVEN.update(files)
    added_choices().clear()
    added_choices().update(added)
