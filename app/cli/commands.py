"""The command line: `lwr-duet serve` (the default), `run`, `bench`, `figures` and `sweep`; every setting of the tree is an option."""

import contextlib
import json
import logging
import math
import sys
import webbrowser
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Final
from urllib.parse import quote

import tyro
from tqdm import tqdm

from app.cli.figures_options import Figures
from app.cli.laws import LawTest, NewLaw, law_test, new_law
from app.cli.lessons import Lessons, lessons
from app.cli.options import AllOptions, Flat, RunOptions, chosen
from app.cli.sweep import Sweep, sweep
from app.runtime.output_file import written
from app.runtime.terminal import INTERRUPTED, ending_at_once
from app.settings import Settings
from controllers.errors import BadInputFile, BadSetting, DuetError
from scenes.files import readable
from scenes.roles import TargetSource
from scenes.settings import RunSettings, values


@dataclass(frozen=True)
class Serve:
    """Open the page: two arms in the browser, one is yours, the other keeps clear."""

    host: str = "127.0.0.1"
    """Address to listen on; 0.0.0.0 lets the whole network in."""
    port: int = 8080
    """Port to listen on."""
    open: bool = True
    """Open the browser."""
    sessions: int = 8
    """How many tabs may have a session of their own at once; in a lecture, how many students may explore by themselves."""
    watchers: int = 200
    """How many pages may be open in a lecture at once; who comes with the key gets in besides."""
    lecture: bool = False
    """A class: all tabs see one stage, students answer on their own; the first tab, or the one with the key, leads."""
    key: str | None = None
    """Who opens the page with ?key=KEY is a teacher: has the notes to the lessons, and in a lecture leads the class. 8 characters or
    more; `auto` makes one and prints the link."""
    allow_origin: tyro.conf.UseAppendAction[tuple[str, ...]] = ()
    """A further web address under which the page may be opened, such as https://duet.example.org behind a proxy; may be given several
    times."""
    bvh: Path | None = None
    """A person's recorded motion to imitate, as BVH; it is there when `source` is `file`."""
    camera: int | None = None
    """Number of a camera at this computer, whose person is imitated when `source` is `camera` (needs the extra `camera`)."""
    video: Path | None = None
    """A video file instead of a camera."""
    pose_model: Path | None = None
    """MediaPipe's model that finds the person, a pose_landmarker .task file."""
    law_file: Path | None = None
    """A law of your own, see `new-law`: it runs instead of ours, and is loaded anew whenever it is saved."""
    lessons: Path | None = None
    """Folder of lessons instead of our own ten; see app/lessons/README.md."""
    settings: Flat[AllOptions] = field(default_factory=AllOptions)  # type: ignore[valid-type]
    """What the page shows at first."""


@dataclass(frozen=True)
class RunOptions:
    """Simulate without a page, as fast as it goes, and print a JSON summary."""

    seconds: float = 46.0
    """Simulated time [s]."""
    inputs: Path | None = None
    """CSV with the header t,x,y,z[,qw,qx,qy,qz]: where the person's hand wants to be; or the recorded inputs of an earlier run. Without
    it the autopilot moves what can be moved."""
    bvh: Path | None = None
    """In `imitation`: a person's recorded motion as BVH, instead of a built-in clip."""
    video: Path | None = None
    """In `imitation`: a person in a video file (needs the extra `camera`)."""
    pose_model: Path | None = None
    """MediaPipe's model that finds the person in the video."""
    csv: Path | None = None
    """Write every step to this CSV file."""
    law_file: Path | None = None
    """A law of your own, see `new-law`, instead of one of ours."""
    settings: Flat[RunOptions] = field(default_factory=RunOptions)  # type: ignore[valid-type]
    """The experiment."""


@dataclass(frozen=True)
class Bench:
    """Measure the step, and what a visitor costs the server; print a table and save JSON."""

    out: Path | None = None
    """Save the figures to this JSON file."""
    compare: Path | None = None
    """Print ratios to the figures in this JSON file."""
    seconds: float = 10.0
    """How long a visitor is watched [s]."""
    steps: int = 9200
    """Steps measured of each scene."""
    peers: bool = False
    """Instead, the hold experiment beside pink and mink: the same arms, pairs and inputs, interleaved (needs the extra `peers`)."""
    fair: bool = False
    """Instead, what a visitor's page has left while another floods the server, sends heavy messages, or comes with a class."""


MOST_STEPS: Final = 1_000_000
"""Longest run; every step of it is kept, at 312 bytes each."""

COMMANDS: Final[dict[str, type]] = {
    "serve": Serve,
    "run": RunOptions,
    "bench": Bench,
    "figures": Figures,
    "sweep": Sweep,
    "lessons": Lessons,
    "new-law": NewLaw,
    "law-test": LawTest,
}


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code: 0, or 2 after one line on stderr that says what is wrong."""
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    if not arguments or (arguments[0].startswith("-") and arguments[0] not in ("-h", "--help")):
        arguments.insert(0, "serve")
    command = tyro.extras.subcommand_cli_from_dict(
        COMMANDS,
        prog="lwr-duet",
        description="Duet: smooth transition between tasks, shown on two KUKA LWR arms (Petrič & Žlajpah, ROBIO 2011). "
        "Without a command it serves the page.",
        args=arguments,
    )
    logging.basicConfig(level=logging.INFO, format="%(levelname)s %(name)s: %(message)s")
    try:
        match command:
            case Serve():
                return serve(command)
            case RunOptions():
                return run(command)
            case Figures():
                with ending_at_once():
                    from app.cli.figures import figures
                return figures(command)
            case Sweep():
                return sweep(command)
            case Lessons():
                return lessons(command)
            case NewLaw():
                return new_law(command)
            case LawTest():
                return law_test(command)
            case _:
                return bench(command)
    except DuetError as error:
        print(f"lwr-duet: {error}", file=sys.stderr)
        return 2


def serve(command: Serve) -> int:
    """Serve the page until Ctrl+C."""
    if command.sessions < 1:
        raise BadSetting(f"sessions = {command.sessions} leaves no place; give a number from 1.")
    if command.watchers < 1:
        raise BadSetting(f"watchers = {command.watchers} leaves no place; give a number from 1.")
    if command.lessons is not None and not command.lessons.is_dir():
        raise BadSetting(f"lessons = {command.lessons}: there is no such folder; name one with lesson files.")
    settings = chosen(command.settings, Settings())
    with ending_at_once():
        from app.classroom.address import find_address
        from app.hosting.teacher_key import chosen_key
        from app.session.input_sources import find_input_sources
        from app.start import start_app

        key = chosen_key(command.key if command.key is None else readable(command.key))
        people = find_input_sources(command.bvh, command.camera, command.video, command.pose_model, command.law_file)
        try:
            house = start_app(
                command.host,
                command.port,
                settings,
                command.sessions,
                command.lecture,
                key,
                command.allow_origin,
                people,
                command.lessons,
                command.watchers,
                ahead=True,
            )
        except Exception:
            people.close()
            raise
    try:
        link = house.url + (f"/?key={quote(key, safe='')}" if key else "")
        print(f"Duet is at {link}   (Ctrl+C ends it)", flush=True)
        if command.lecture:
            print(f"The class opens {find_address('', command.host, house.server.get_port()).url}", flush=True)
        if command.open:
            webbrowser.open(link)
        house.wait()
    except KeyboardInterrupt:
        return INTERRUPTED
    finally:
        house.close()
    return 0


def run(command: RunOptions) -> int:
    """Simulate, and print the summary."""
    with ending_at_once():
        from app.custom_law.custom_law import CustomLaw
        from scenes.headless import run as simulate
        from scenes.recording import write_table

    settings: RunSettings = chosen(command.settings, RunSettings())
    longest = MOST_STEPS * settings.dt
    if not 0.0 < command.seconds <= longest:
        raise BadSetting(f"seconds = {command.seconds:g} is out of range; give a number up to {longest:g} (or a larger dt).")
    person = _person(command, settings)
    if command.csv is not None and not command.csv.parent.is_dir():
        raise BadSetting(f"csv = {command.csv}: there is no folder {command.csv.parent}; make it first.")
    steps = round(command.seconds / settings.dt)
    with contextlib.ExitStack() as stack:
        own = None if command.law_file is None else stack.enter_context(CustomLaw(command.law_file, waits=True))
        bar = stack.enter_context(tqdm(total=steps, unit="step", disable=None, delay=1.0, leave=False))
        done = simulate(settings, command.seconds, person, on_progress=bar.update, law=own)
        if own is not None and own.problem is not None:
            # From there on the arm stood still: no result that anybody should take for one.
            raise BadInputFile(own.problem.text)
    if command.csv is not None:
        header = {
            **values(settings),
            **({"law_file": readable(command.law_file.name)} if command.law_file else {}),
            "seconds": command.seconds,
            "inputs": next((readable(path.name) for path in (command.inputs, command.bvh, command.video) if path), "autopilot"),
        }
        with written(command.csv, "csv") as new, new.open("w", encoding="utf-8", newline="\n") as out:
            write_table(out, done.simulation, done.table, header)
    # JSON knows no infinity, which is the distance where nothing can be met.
    figures = {key: None if value == math.inf else value for key, value in asdict(done.summary).items()}
    print(json.dumps(figures, indent=2))
    return 0


def _person(command: RunOptions, settings: RunSettings) -> TargetSource | None:
    """Return who moves what can be moved; None for the experiment's own person."""
    from app.session.input_sources import MODEL_REMEDY, PersonTarget, from_bvh
    from scenes.inputs_file import read_person

    given = [name for name in ("inputs", "bvh", "video") if getattr(command, name) is not None]
    if len(given) > 1:
        raise BadSetting(f"{' and '.join(f'--{name}' for name in given)} are several sources for one person; give one of them.")
    if given and given[0] != "inputs" and settings.scene != "imitation":
        raise BadSetting(f"--{given[0]} is a person to imitate; add --scene imitation.")
    if command.inputs is not None:
        return read_person(command.inputs, settings)
    if command.bvh is not None:
        from scenes.person.bvh import read_bvh

        return from_bvh(read_bvh(command.bvh))
    if command.video is not None:
        from scenes.person.camera import read_film
        from scenes.person.film import open_detector, open_video

        if command.pose_model is None:
            raise BadSetting(f"A video needs a model that finds the person: {MODEL_REMEDY}.")
        return PersonTarget(read_film(open_video(command.video), open_detector(command.pose_model)))
    return None


def bench(command: Bench) -> int:
    """Measure, print and save."""
    with ending_at_once():
        from app.bench.measurements import compare, measure, measure_fairness, read_figures, table_text
        from app.bench.peers import measure_peers, peers_table

    before = read_figures(command.compare) if command.compare else None
    if command.peers:
        result = measure_peers(command.steps)
        print(peers_table(result))
    elif command.fair:
        result = measure_fairness(command.seconds)
        print(table_text(result))
    else:
        result = measure(command.steps, command.seconds)
        print(table_text(result))
    if before is not None:
        print(compare(result, before))
    if command.out is not None:
        with written(command.out, "out") as new:
            new.write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8", newline="\n")
    return 0
