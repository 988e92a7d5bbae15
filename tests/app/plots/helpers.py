"""Runs to plot, a panel of plots that needs no browser, and ways to read what it shows."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cache
from typing import Any, cast, get_args

import numpy as np
import viser

from app.page.panels.plots_panel import Plots
from app.session.session import Session
from app.settings import Details, PageSettings, Settings
from scenes.settings import LawName, LawSettings, RobotName, RunSettings, SceneName
from scenes.simulation import Simulation

SCENES: tuple[SceneName, ...] = get_args(SceneName)
LAWS: tuple[LawName, ...] = get_args(LawName)
DETAILS: tuple[Details, ...] = get_args(Details)


@cache
def played(
    scene: SceneName = "hold", law: LawName = "smooth_priority", robot: RobotName = "lwr", seconds: float = 1.5
) -> Simulation:
    """An experiment that its own person has moved for a while; not to be moved on."""
    settings = RunSettings(scene=scene, robot=robot, law=LawSettings(law=law))
    simulation = Simulation(settings)
    person = simulation.source()
    while simulation.time < seconds:
        simulation.step(person.target(simulation.time))
    return simulation


def text(html: str) -> str:
    """What a person reads."""
    return re.sub(r"<[^>]+>", " ", html)


def paths(html: str, kind: str) -> list[np.ndarray]:
    """The points of the lines of a kind, in thousandths of the chart's width and height."""
    return [
        np.array([[float(v) for v in point.split()] for point in re.findall(r"(-?\d+ -?\d+)", d)])
        for d in re.findall(rf'<path class="{kind}" d="M([^"]*)"', html)
    ]


def marks(html: str, kind: str) -> list[tuple[float, float]]:
    """Where the marks of a kind are, in shares of the chart's width and height."""
    found = re.findall(rf'<b class="{kind}" style="left:([\d.]+)%;top:([\d.]+)%">', html)
    return [(float(x) / 100.0, float(y) / 100.0) for x, y in found]


@dataclass
class Handle:
    """What a plot or a block was told, in order."""

    told: list[tuple[str, Any]] = field(default_factory=list)

    def __setattr__(self, name: str, value: Any) -> None:
        if name != "told":
            self.told.append((name, value))
        object.__setattr__(self, name, value)


@dataclass
class Gui:
    """Makes blocks and plots."""

    blocks: list[Any] = field(default_factory=list)
    plots: list[Any] = field(default_factory=list)

    def add_html(self, content: str, **options: Any) -> Any:
        """A block."""
        handle = Handle()
        handle.content, handle.visible, handle.order = content, True, options["order"]
        self.blocks.append(handle)
        return handle

    def add_uplot(self, **options: Any) -> Any:
        """A plot; viser asks for arrays of one length here."""
        assert len(options["data"]) == len(options["series"]) and len({len(line) for line in options["data"]}) == 1
        handle = Handle()
        for name, value in options.items():
            setattr(handle, name, value)
        handle.visible = True
        self.plots.append(handle)
        return handle


class Tab:
    """A place."""

    def __enter__(self) -> None:
        """Nothing to do."""

    def __exit__(self, *_: object) -> None:
        """Nothing to do."""


def panel(session: Session) -> tuple[Plots, Gui]:
    """The panel of a session, without a browser."""
    gui = Gui()
    page = session.settings.page
    return Plots(cast(viser.GuiApi, gui), cast(viser.GuiTabHandle, Tab()), page, 150), gui


def session_of(scene: SceneName, details: Details, **page: Any) -> Session:
    """A session without a clock."""
    return Session(Settings(RunSettings(scene=scene), PageSettings(details=details, **page)))


def go_on(session: Session, seconds: float) -> None:
    """Simulate, whatever the time of day is."""
    until = session.simulation.time + seconds
    while session.simulation.time < until:
        session.advance(0.02)
