"""The installed version."""

import importlib.metadata


def duet_version() -> str:
    """Version, "0" for a bare checkout."""
    try:
        return importlib.metadata.version("lwr-duet")
    except importlib.metadata.PackageNotFoundError:
        return "0"
