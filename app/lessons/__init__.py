"""The walkthrough without its page: lessons as files, what they measure, a student's way through them, and the check of it all.

`loading` reads a folder of lessons, `walkthrough` is one student in it, `check` walks every path. Nothing here draws anything.
"""

from pathlib import Path
from typing import Final

FOLDER: Final = Path(__file__).parent
"""Where our own eleven lessons are."""
