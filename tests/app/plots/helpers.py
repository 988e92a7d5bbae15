"""Runs to plot, a panel of plots without a browser, and readers of its contents."""

import re
from contextlib import nullcontext
from dataclasses import dataclass, field
from functools import cache
from typing import Any, cast, get_args

import numpy as np
import viser

from app.page.panels.plots_panel import Plots
from app.session.frame import freeze
from app.session.session import Session
from app.settings import Details, PageSettings, Settings
from scenes.experiments import EXPERIMENTS
from scenes.settings import LawSettings, RobotName, RunSettings
from scenes.simulation import Simulation
from tests.scenes.helpers import moved

SCENES = tuple(EXPERIMENTS)
DETAILS: tuple[Details, ...] = get_args(Details)


@cache
def played(
    scene: str = "hold", law: str = "smooth_priority", robot: RobotName = "lwr", seconds: float = 1.5
) -> Simulation:
    """An experiment after some seconds with its own person. Shared: do not step it."""
    settings = RunSettings(scene=scene, robot=robot, law=LawSettings(law=law))
    return moved(settings, lambda simulation: simulation.time >= seconds)


def text(html: str) -> str:
    return re.sub(r"<[^>]+>", " ", str(html))


def paths(html: str, kind: str) -> list[np.ndarray]:
    """Points of a kind's lines [thousandths of the chart's width and height]."""
    return [
        np.array([[float(v) for v in point.split()] for point in re.findall(r"(-?\d+ -?\d+)", d)])
        for d in re.findall(rf'<path class="{kind}" d="M([^"]*)"', html)
    ]


def marks(html: str, kind: str) -> list[tuple[float, float]]:
    """Places of a kind's marks [shares of the chart's width and height]."""
    found = re.findall(rf'<b class="{kind}" style="left:([\d.]+)%;top:([\d.]+)%">', html)
    return [(float(x) / 100.0, float(y) / 100.0) for x, y in found]


@dataclass
class Handle:
    sent: list[tuple[str, Any]] = field(default_factory=list)

    def __setattr__(self, name: str, value: Any) -> None:
        if name != "sent":
            self.sent.append((name, value))
        object.__setattr__(self, name, value)


@dataclass
class Gui:
    blocks: list[Any] = field(default_factory=list)
    plots: list[Any] = field(default_factory=list)

    def add_html(self, content: str, **options: Any) -> Any:
        return self._add(self.blocks, content=content, **options)

    def add_uplot(self, **options: Any) -> Any:
        """A plot. viser requires arrays of equal length here."""
        assert (
            len(options["data"]) == len(options["series"])
            and len({len(line) for line in options["data"]}) == 1
        )
        return self._add(self.plots, **options)

    def _add(self, to: list[Any], **options: Any) -> Handle:
        to.append(Handle())
        for name, value in {**options, "visible": True}.items():
            setattr(to[-1], name, value)
        return to[-1]


def go_on(session: Session, seconds: float) -> None:
    until = session.simulation.time + seconds
    while session.simulation.time < until:
        session.advance(0.02)


class ShownPanel:
    """A session without a clock, with its panel of plots, without a browser."""

    def __init__(self, scene: str, details: Details = "none", **page: Any) -> None:
        self.session = Session(Settings(RunSettings(scene=scene), PageSettings(details=details, **page)))
        self.gui, self.now = Gui(), -1.0
        gui, tab = cast(viser.GuiApi, self.gui), cast(viser.GuiTabHandle, nullcontext())
        self.panel = Plots(gui, tab, self.session.settings.page, 150)

    def show(self, after: float = 0.0, wait: float = 1.0, **changes: Any) -> list[Any]:
        """Change settings, simulate `after` seconds, show a frame `wait` seconds later. Return the plots."""
        for key, value in changes.items():
            self.session.change(key, value)
        go_on(self.session, after)
        self.now += wait
        self.panel.show(freeze(self.session, self.now))
        return self.gui.plots

    def says(self, words: str) -> int:
        return sum(words in block.content for block in self.gui.blocks)
