"""The installed version."""

import importlib.metadata


def duet_version() -> str:
    """The installed version of Duet, "0" when it runs from a bare checkout."""
    try:
        return importlib.metadata.version("lwr-duet")
    except importlib.metadata.PackageNotFoundError:
        return "0"
