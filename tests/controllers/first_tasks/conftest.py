"""Thousands of postures a test: in machine code."""

import pytest

from controllers import compiled


@pytest.fixture(autouse=True, scope="session")
def machine_code() -> None:
    compiled.load_now()
