"""`lwr-duet figures`."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from app.features.sweep.computing import computing
from app.runtime.progress import progress
from app.runtime.terminal import ending_at_once
from controllers.errors import BadSetting
from scenes.files import written


@dataclass(frozen=True)
class Figures:
    """Draw the paper's figures and ours, and write a report.

    The runs are made by this call; each figure is written as PNG, SVG and CSV."""

    only: str = ""
    """Numbers of the paper's figures or names, such as 2,5,laws; all without it."""
    out: Path = Path("figures")
    """Folder for the files; it is made if it does not exist."""
    seed: int = 1
    """Seed of every random person."""
    quick: bool = False
    """Shorter runs and fewer points."""
    workers: int = 0
    """Processes; 0 takes one a core."""


def draw_figures(command: Figures) -> int:
    """Returns the exit code.

    Raises:
        BadSetting: unknown figure, bad seed or workers, or a folder that cannot be written to.
    """
    with ending_at_once():
        import matplotlib

        from app.features.figures.drawn_figure import STYLE, Plan, save_figure
        from app.features.figures.figure_list import FigureEntry, chosen_figures, report
        from app.version import duet_version
        from scenes.setting_spec import checked
        from scenes.settings import RunSettings, specs

    entries = chosen_figures(command.only)
    seed = checked(specs(RunSettings)["seed"], 1, command.seed)
    try:
        command.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadSetting(
            f"out = {command.out}: cannot be made ({error.strerror}); give another folder."
        ) from None
    sections: list[tuple[FigureEntry, Sequence[str]]] = []
    bar = progress(len(entries), "figure")
    # The second bar counts the simulated steps of one figure.
    steps = progress(None, "step", unit_scale=True, position=1, mininterval=0.2)
    with bar, steps, computing(command.workers, None) as compute:
        plan = Plan(seed, command.quick, steps.update, compute)
        for entry in entries:
            bar.set_description(entry.name)
            steps.reset()
            # The style is for these figures only, not for others of the same process.
            with matplotlib.rc_context(STYLE):
                drawn = entry.draw(plan)
                save_figure(drawn, command.out, entry.stem)
            sections.append((entry, drawn.found))
            bar.update()
    path = command.out / "report.md"
    with written(path, "out") as new:
        new.write_text(report(sections, plan, duet_version()), encoding="utf-8", newline="\n")
    print(f"{len(sections)} figures and {path}")
    return 0
