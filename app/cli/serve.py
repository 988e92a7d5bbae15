"""`lwr-duet serve`: the page."""

import os
import socket
import webbrowser
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, make_dataclass, replace
from functools import partial
from typing import Any, Final, Literal
from urllib.parse import quote

import tyro

from app.cli.options import Flat, all_options, glides_as_usual, in_one_list, settings_of_options, shown_alone
from app.feature import Feature
from app.hosting.serve_options import FeatureOptions, ServeOptions
from app.hosting.teacher_key import AUTO, chosen_key
from app.runtime.temporary_folder import remove_abandoned
from app.runtime.terminal import INTERRUPTED, ending_at_once, terminated
from app.settings import Settings
from app.text.experiment_texts import EXPERIMENT_TEXTS
from app.web.listening import listen, listen_near, url_of
from app.web.origin_policy import is_loopback
from controllers.errors import BadSetting
from scenes.files import readable
from scenes.given_robots import GIVEN

PROOF_VARIABLE: Final = "DUET_PROOF"
"""Environment variable with the secret of a notebook server's tile, see `app.web.origin_policy.PROOF`."""

KEY_VARIABLE: Final = "DUET_KEY"
"""Environment variable with the teacher's key."""

IN_BRIEF: Final = ("host", "port", "open", "key")
"""Options of the server that `serve --help` shows."""

SETTINGS_IN_BRIEF: Final = ("scene", "robot", "law", "profile", "lang")
"""Settings that `serve --help` shows."""

USUAL_PORT: Final = 8080
"""Default port, unless another program has it."""


@dataclass(frozen=True)
class Serve:
    """Open the page: you move one arm, the other keeps clear."""

    host: str = ServeOptions.host
    """Address to listen on; 0.0.0.0 lets the whole network in."""
    port: int | Literal["auto"] = "auto"
    """Port to listen on; `auto`: 8080, or the next free one, which the start says."""
    open: bool = True
    """Open the browser."""
    sessions: int | Literal["auto"] = "auto"
    """Most tabs with a session of their own at once. `auto`: as many as this machine carries at 20 frames a second; with --host, --key
    or other options that let others in, the start says about how many that is."""
    key: str | None = None
    """Visitors who open the page with ?key=KEY are teachers: they see the notes to the lessons. 12 characters or more; `auto` makes one
    and prints the link. Without this option, the environment variable DUET_KEY, which the list of processes does not show."""
    allow_origin: tyro.conf.UseAppendAction[tuple[str, ...]] = ()
    """A further web address under which the page may be opened, such as https://duet.example.org behind a proxy; may be given several
    times."""
    embed_origin: tyro.conf.UseAppendAction[tuple[str, ...]] = ()
    """The web address of a page that may show this one in a frame, such as https://moodle.example.org; may be given several times."""
    settings: object = None
    """What the page shows at first."""


def serve_with(features: Sequence[Feature]) -> type[Serve]:
    """Options of the command with those of the features, each a field of the feature's name."""
    # Features may have added choices to settings since this file was imported.
    settings = all_options()
    added: list[tuple[str, Any, Any]] = [("settings", Flat[settings], field(default_factory=settings))]  # type: ignore[valid-type]
    added += [
        (one.name, Flat[one.options()], field(default_factory=one.options()))
        for one in features
        if one.options is not None
    ]
    return make_dataclass("Serve", added, bases=(Serve,), frozen=True, namespace={"__doc__": Serve.__doc__})


def brief_serve_with(features: Sequence[Feature]) -> type:
    """Options of `serve --help` in one list: those of the server, settings, and those declared by features."""
    parts = {"settings": shown_alone(all_options(), SETTINGS_IN_BRIEF)}
    for one in features:
        if one.options is not None and (names := one.options().in_brief):
            parts[one.name] = shown_alone(one.options(), names)
    added: list[tuple[str, Any, Any]] = [
        (name, in_one_list(options), field(default_factory=options)) for name, options in parts.items()
    ]
    shown = shown_alone(Serve, (*IN_BRIEF, "settings"))
    return make_dataclass("Serve", added, bases=(shown,), frozen=True, namespace={"__doc__": Serve.__doc__})


def serve(command: Serve, features: Sequence[Feature]) -> int:
    """Serve the page until Ctrl+C or SIGTERM; return the exit code.

    Args:
        command: an object of `serve_with` the features.

    Raises:
        BadSetting, BadInputFile, PortInUse: before anything is served.
        DuetError: see `FeatureOptions.held`.
    """
    if isinstance(command.sessions, int) and command.sessions < 1:
        raise BadSetting("--sessions must be at least 1, or auto.")
    of_features: tuple[FeatureOptions, ...] = tuple(
        getattr(command, one.name) for one in features if one.options is not None
    )
    for one in of_features:
        one.check()
    settings = settings_of_options(command.settings, Settings())
    _draw_given_robots()
    given = command.key or os.environ.get(KEY_VARIABLE)
    key = chosen_key(None if given is None else readable(given))
    options = ServeOptions(
        host=command.host,
        port=USUAL_PORT if command.port == "auto" else command.port,
        settings=settings,
        glides_as_usual=glides_as_usual(command.settings),
        sessions=None if command.sessions == "auto" else command.sessions,
        key=key,
        allowed_origins=command.allow_origin,
        embed_origins=command.embed_origin,
        # Processes that features start inherit the environment.
        proof=os.environ.pop(PROOF_VARIABLE, ""),
        ahead=True,
        features=of_features,
    )
    for one in of_features:
        one.fits(options)
    remove_abandoned()
    try:
        with ExitStack() as held:
            bind = listen_near if command.port == "auto" else listen
            listener = bind(options.host, options.port)
            held.callback(listener.close)
            options = replace(options, port=listener.getsockname()[1])
            options = replace(options, features=tuple(one.held(options.port, held) for one in of_features))
            announce = partial(_announce, command, options)
            started = (
                one.start(options, listener, features, announce) for one in features if one.start is not None
            )
            if not any(started):
                _serve_here(options, listener, features, announce)
    except KeyboardInterrupt:
        return INTERRUPTED
    return 0


def _draw_given_robots() -> None:
    """Build the drawings of given robots, so that a fault in a file appears now and not on a visitor's page.

    Raises:
        BadInputFile: one of them cannot be drawn.
    """
    if GIVEN:
        with ending_at_once():
            from scenes.robots.drawing import draw_given

            for name in GIVEN:
                draw_given(name)


def _serve_here(
    options: ServeOptions,
    listener: socket.socket,
    features: Sequence[Feature],
    announce: Callable[[int], None],
) -> None:
    with ending_at_once():
        from app.start import start_app

        app = start_app(options, features, listener)
    try:
        announce(app.context.workload.places)
        app.wait()
    finally:
        app.close(terminated())


def _announce(command: Serve, options: ServeOptions, places: int) -> None:
    key, port = options.key, options.port
    made = (command.key or os.environ.get(KEY_VARIABLE)) == AUTO
    link = url_of(command.host, port) + (f"/?key={quote(key, safe='')}" if key else "")
    # The output of a service is its log: print the key only if it was made here.
    lines = [f"Duet is at {link if made or not key else link.partition('=')[0] + '=KEY'}"]
    if command.port == "auto" and port != USUAL_PORT:
        lines.append(f"Port {USUAL_PORT} is taken by another program, so this Duet has port {port}.")
    lines += [line for one in options.features for line in one.said_at_start(command.host, port, places)]
    if command.sessions == "auto" and _is_for_others(options):
        lines.append(f"This machine carries about {places} sessions at once.")
    lines += [_what_to_try(options.settings), "Ctrl+C ends it."]
    for line in lines:
        print(line, flush=True)
    if command.open:
        webbrowser.open(link)


def _is_for_others(options: ServeOptions) -> bool:
    """True if other people than the one who starts the server are expected."""
    reached = not is_loopback(options.host) or options.allowed_origins or options.embed_origins
    return bool(reached or options.key or options.shared)


def _what_to_try(settings: Settings) -> str:
    """First text of the page on its experiment."""
    return EXPERIMENT_TEXTS[settings.run.scene](settings.run, settings.page.autopilot).tip
