"""Machine code for these tests, which compute thousands of postures."""

import pytest

from controllers import compiled


@pytest.fixture(autouse=True, scope="session")
def machine_code() -> None:
    compiled.load_now()
