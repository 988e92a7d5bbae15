"""Servers in separate processes, for features that test several processes."""

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from tests.app.features.workers.served import Serve, Served


@pytest.fixture
def serve(request: pytest.FixtureRequest, tmp_path: Path) -> "Serve":
    """`serve("--workers", "2")` starts the command with the test's store."""
    # Imported here: without the feature `workers` its tests are deleted, too.
    from tests.app.features.workers.served import Served

    def make(*options: str) -> "Served":
        served = Served(tmp_path, *options)
        request.addfinalizer(served.close)
        return served

    return make
