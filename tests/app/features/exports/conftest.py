"""Fixture with the path of a custom law, for runs with one."""

from tests.app.features.custom_law.conftest import file

__all__ = ["file"]
