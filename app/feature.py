"""What a feature may add to the core, which knows only this type; `app.features` has all features in one
tuple.

The `__init__.py` of a feature's folder makes one `Feature`. Its members are functions that import what they
return, so that the tuple is cheap to import.
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
    # What the core's commands read of a feature must not load the page.
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

GROUPS: Final[tuple[Group, ...]] = get_args(Group)


@dataclass(frozen=True)
class Command:
    """A command of `lwr-duet`.

    Attributes:
        options: dataclass; its docstring and fields are the command's help, the first line also its line in
            the help of `lwr-duet`.
        run: does it and returns the exit code.
        brief: makes the options of `--help` if `--help-all` shows more; None if `--help` shows all.

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
    """What one feature adds; every member except the name is optional.

    Attributes:
        name: of its folder in `app/features`.
        texts: folder with one catalogue per language (`de.toml`) for this feature's texts.
        choices: key of a setting → value → label of further choices.
        documents: last part of the address → document.
        commands: name → command.
        panels: makes the operator's panels; those of the lowest feature come first.
        charts: choice of the setting `plot` → chart.
        key_help: rows for the page's table of keys, for keys with a temporary meaning.
        overlays: makes the parts of a page that shows a session, operated or not; see
            `app.page.view.ViewPart`.
        assets: scripts and style sheets of every page.
        options: dataclass that adds its fields to the options of `lwr-duet serve`.
        start: serves a page on a listening socket and then calls a function with the number of places;
            returns False at once if this process shall serve the page.
        robot_reader: reads the robot of a file named on the command line, see `scenes.given_robots`.
        run_source: dataclass that adds its fields to the options of `lwr-duet run`.
        opened: opens what all sessions of a server share, before anything is served.
        host: makes the host of a server started with the feature's options, or returns None.
        server: makes the feature's state for a whole server.
        joining: makes the pages of people who join a visitor's private session by a link.
        store: makes the store of the sessions of absent visitors.
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
