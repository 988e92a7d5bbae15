"""What a feature may add to the core, which knows only this type.

The `__init__.py` of a feature's folder makes one `Feature`; its functions import late, so that `app.features`
is cheap to import.
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
        options: dataclass; its docstring and fields are the help, the first line also in that of `lwr-duet`.
        run: returns the exit code.
        brief: makes the options of `--help` if `--help-all` shows more.

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
    """What one feature adds.

    Attributes:
        name: of its folder in `app/features`.
        texts: folder with its catalogues (`de.toml`).
        choices: key of a setting → value → label.
        documents: last part of the address → document.
        panels: makes the operator's panels; the lowest feature's come first.
        charts: choice of the setting `plot` → chart.
        key_help: rows of the table of keys, for temporary meanings.
        overlays: makes parts of pages that show a session, operated or not.
        options: dataclass of options of `lwr-duet serve`.
        start: serves a page on a listening socket and then calls a function with the number of places;
            returns False at once if this process shall serve the page.
        robot_reader: reads a robot file of the command line.
        run_source: dataclass of options of `lwr-duet run`.
        opened: opens shared state of all sessions, before anything is served.
        host: makes a host if the feature's options ask for one.
        joining: makes pages that join a visitor's private session by a link.
        store: makes the store of absent visitors' sessions.
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
