"""What a feature may add to the core, which knows this type and no feature; `app.features` has all of them in one tuple.

A feature is a folder. Its `__init__.py` makes one `Feature`. The members are functions that import what they return, so that the tuple
costs nothing to import.
"""

import socket
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, get_args

from app.plots.chart_list import Charts
from app.text.document_list import DocumentFile
from scenes.given_robots import RobotReader

if TYPE_CHECKING:
    # What a command of the core needs to know of a feature loads no page.
    from app.hosting.app_context import AppContext
    from app.hosting.host import Host
    from app.hosting.joining_pages import JoiningPages
    from app.hosting.opened_feature import OpenedFeature
    from app.hosting.parking import Parking
    from app.hosting.serve_options import FeatureOptions, ServeOptions
    from app.hosting.server_part import ServerPart
    from app.page.panel_context import PanelMaker
    from app.page.panels.hotkeys import KeyHelp
    from app.page.view import View, ViewPart
    from app.recording.run_source import RunSource
    from app.web.pages import PageAssets


Group = Literal["show", "teach", "compute"]
"""Group of commands in the help of `lwr-duet`."""

GROUPS: Final[tuple[Group, ...]] = get_args(Group)
"""All groups, in the order of the help."""


@dataclass(frozen=True)
class Command:
    """A command of `lwr-duet`.

    Attributes:
        options: a dataclass; its docstring and fields are the command's help. The first line of the docstring is the
            command's line in the help of `lwr-duet`.
        run: does it, and returns the exit code.
        group: which group of that help names it.
        brief: makes the options that `--help` shows if `--help-all` shows the rest; None if `--help` shows all.

    Raises:
        ValueError: unknown group.
    """

    options: type
    run: Callable[[Any], int]
    group: Group
    brief: Callable[[], type] | None = None

    def __post_init__(self) -> None:
        if self.group not in GROUPS:
            raise ValueError(f"unknown group of commands {self.group!r}; the groups are {', '.join(GROUPS)}")


@dataclass(frozen=True)
class Feature:
    """What one feature adds; every member but the name is optional.

    Attributes:
        name: of its folder in `app/features`.
        texts: folder with a catalogue a language, `de.toml` and so on, for the texts of this feature alone.
        choices: key of a setting → value → label of further choices.
        documents: last part of the address → document that the page offers.
        commands: name → command.
        panels: what makes the panels of a visitor who operates a session. Those of the lowest feature are made first.
        charts: choice of the setting `plot` → chart.
        key_help: rows for the page's table of keys, of keys that mean something at times.
        overlays: what makes the parts of a page that shows a session, operated or not; see `app.page.view.ViewPart`.
        assets: scripts and style sheets of every page.
        options: a dataclass that adds its fields to the options of `lwr-duet serve`.
        start: serves a page on a socket that listens, and calls a function with the number of places when it does; returns False at
            once if the page is to be served in this process.
        robot_reader: gives the robot of a file that the command line names, see `scenes.given_robots`.
        run_source: a dataclass that adds its fields to the options of `lwr-duet run`.
        opened: opens what all sessions of a server share, before anything is served.
        host: makes the host of a server that is started with the feature's options, or returns None.
        server: makes what the feature keeps for a whole server.
        joining: makes the pages of people who join a visitor's private session by a link.
        store: makes what keeps the sessions of visitors who are away, and perhaps more.
    """

    name: str
    texts: Path | None = None
    choices: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    documents: Mapping[str, DocumentFile] = field(default_factory=dict)
    commands: Callable[[], Mapping[str, Command]] | None = None
    panels: "Callable[[], Sequence[PanelMaker]] | None" = None
    charts: Callable[[], Charts] | None = None
    key_help: "Callable[[], Sequence[KeyHelp]] | None" = None
    overlays: "Callable[[], Sequence[Callable[[View], ViewPart]]] | None" = None
    assets: "Callable[[], PageAssets] | None" = None
    options: "Callable[[], type[FeatureOptions]] | None" = None
    start: "Callable[[ServeOptions, socket.socket, Sequence[Feature], Callable[[int], None]], bool] | None" = None
    robot_reader: RobotReader | None = None
    run_source: "Callable[[], type[RunSource]] | None" = None
    opened: "Callable[[ServeOptions], OpenedFeature] | None" = None
    host: "Callable[[AppContext], Host | None] | None" = None
    server: "Callable[[AppContext], ServerPart] | None" = None
    joining: "Callable[[AppContext], JoiningPages] | None" = None
    store: "Callable[[ServeOptions], Parking] | None" = None
