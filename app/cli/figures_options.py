"""What `lwr-duet figures` is asked for; apart from the drawing, whose libraries take a second to load."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Figures:
    """Draw the paper's figures and ours from runs of this call: PNG, SVG, CSV and a report."""

    only: str = ""
    """Numbers of the paper's figures or names, such as 2,5,laws; all without it."""
    out: Path = Path("figures")
    """Folder for the files; it is made if it does not exist."""
    seed: int = 1
    """Seed of everybody who plays a part."""
    quick: bool = False
    """Shorter runs and fewer points."""
