"""Where a student's law is."""

from __future__ import annotations

from pathlib import Path

import pytest


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Where the law is."""
    return tmp_path / "my_law.py"
