"""`lwr-duet figures`: which figures, where to, and how thoroughly."""

import matplotlib
from tqdm import tqdm

from app.cli.figures_options import Figures
from app.figures.drawn_figure import save
from app.figures.figure_list import chosen
from app.figures.figure_style import STYLE
from app.figures.figures_report import Section, report
from app.figures.run_plan import Plan
from app.runtime.output_file import written
from app.version import duet_version
from controllers.errors import BadSetting
from scenes.settings import RunSettings, checked, specs


def figures(command: Figures) -> int:
    """Draw, save and report; return the exit code.

    Raises:
        BadSetting: no such figure, a bad seed, or a folder that cannot be written to.
    """
    entries = chosen(command.only)
    seed = checked(specs(RunSettings)["seed"], 1, command.seed)
    try:
        command.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadSetting(f"out = {command.out}: cannot be made ({error.strerror}); give another folder.") from None
    sections: list[Section] = []
    with tqdm(total=len(entries), unit="figure", disable=None, leave=False) as bar, _steps() as steps:
        plan = Plan(seed, command.quick, steps.update)
        for entry in entries:
            bar.set_description(entry.name)
            steps.reset()
            # The style belongs to these figures, not to others that are drawn in this process.
            with matplotlib.rc_context(STYLE):
                drawn = entry.draw(plan)
                save(drawn, command.out, entry.stem)
            sections.append(Section(entry, drawn.found))
            bar.update()
    path = command.out / "report.md"
    with written(path, "out") as new:
        new.write_text(report(sections, plan, duet_version()), encoding="utf-8", newline="\n")
    print(f"{len(sections)} figures and {path}")
    return 0


def _steps() -> tqdm:  # type: ignore[type-arg]
    """Return the second bar: steps simulated for the figure at work."""
    return tqdm(unit="step", unit_scale=True, disable=None, leave=False, position=1, mininterval=0.2)
