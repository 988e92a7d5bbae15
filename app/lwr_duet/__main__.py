"""The installed command `lwr-duet`, and `python -m lwr_duet`: Duet's, also where PYTHONPATH names another `app`."""

# First: it finds our packages.
import lwr_duet  # noqa: F401, I001  # pyright: ignore[reportMissingImports]
from app.__main__ import entry

__all__ = ["entry"]

if __name__ == "__main__":
    entry()
