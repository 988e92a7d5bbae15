"""Where a student's law is, for runs with one."""

from tests.app.features.custom_law.conftest import file

__all__ = ["file"]
