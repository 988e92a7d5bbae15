"""The command line: output, files and refusals."""

import json
import os
import re
import socket
import subprocess
import sys
import urllib.request
import webbrowser
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, cast

import numpy as np
import pinocchio as pin
import pytest

from app.__main__ import run_command as main
from app.cli.main import main as command_line
from app.cli.options import NO_WORLD, PLACES, RunOptions, all_options, glides_as_usual, settings_of_options
from app.cli.serve import Serve
from app.feature import Feature
from app.features import FEATURES
from app.hosting.serve_options import FeatureOptions, ServeOptions
from app.hosting.teacher_key import SHORTEST
from app.runtime.terminal import INTERRUPTED
from app.settings import Settings, from_query
from app.start import App
from app.text.experiment_texts import EXPERIMENT_TEXTS
from app.web.listening import listen_near
from scenes.experiments import BALL, HOLD
from scenes.room import build_room
from scenes.settings import LATER, RunSettings, changed, specs, values
from tests.browser import free_port
from tests.scenes.test_recording import HEADER, JOINTS

SUMMARY = """d_min d_min_pair share_below e2_max e2_end dq_step_max ddq_max pair_switches pair_switches_felt out_of_authority_s
    steps step_us_median"""


def run(capsys: pytest.CaptureFixture[str], *options: str) -> dict[str, Any]:
    assert main(["run", *options]) == 0
    return json.loads(capsys.readouterr().out)


def refused(
    capsys: pytest.CaptureFixture[str], *arguments: str, features: Sequence[Feature] = FEATURES
) -> str:
    assert command_line(list(arguments), features) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    lines = captured.err.splitlines()
    assert len(lines) == 1 and lines[0].startswith("lwr-duet: "), captured.err
    return lines[0]


def read(path: Path) -> tuple[dict[str, str], list[str], list[dict[str, str]]]:
    """Settings in # lines, header and rows of an output file."""
    lines = path.read_text(encoding="utf-8").splitlines()
    top = [line for line in lines if line.startswith("#")]
    assert lines[: len(top)] == top
    header = lines[len(top)].split(",")
    rows = [dict(zip(header, line.split(","), strict=True)) for line in lines[len(top) + 1 :]]
    return dict(cast(tuple[str, str], tuple(line[2:].split(" = ", 1))) for line in top), header, rows


def test_summary(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    out = tmp_path / "out.csv"
    summary = run(capsys, "--seconds", "4", "--csv", str(out), "--dm", "0.2", "--pairs", "single")
    assert list(summary) == SUMMARY.split()
    assert summary["steps"] == 800 and summary["step_us_median"] > 0.0 and " / " in summary["d_min_pair"]
    # The summary agrees with the rows.
    settings, header, rows = read(out)
    assert header == HEADER and len(rows) == 800
    assert (
        settings["dm"] == "0.2"
        and settings["pairs"] == "single"
        and set(specs(RunSettings)) - set(LATER) <= set(settings)
    )
    d = np.array([float(row["d"]) for row in rows])
    assert summary["d_min"] == d.min() and rows[int(d.argmin())]["pair"] == summary["d_min_pair"]
    assert summary["share_below"] == (d < 0.2).mean() and summary["e2_end"] == float(rows[-1]["e2"])
    assert np.allclose([float(row["t"]) for row in rows], np.arange(800) * 0.005)


def test_the_same_run_writes_the_same_bytes(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    written: list[bytes] = []
    for seed in ("3", "3", "4"):
        run(capsys, "--seconds", "2", "--seed", seed, "--csv", str(tmp_path / "out.csv"))
        written.append((tmp_path / "out.csv").read_bytes())
    assert written[0] == written[1] != written[2]


def test_inputs_drive_the_hand(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    room = build_room("torso")
    data, hand = room.model.createData(), room.arm("right").hand
    pin.framesForwardKinematics(room.model, data, room.start)
    start = data.oMf[hand].copy()
    goal = pin.SE3(
        pin.rpy.rpyToMatrix(0.0, 0.0, 0.3) @ start.rotation, start.translation + np.array([0.05, -0.10, 0.05])
    )
    q = pin.Quaternion(goal.rotation)
    lines = [
        ",".join(map(str, (t, *p, q.w, q.x, q.y, q.z)))
        for t, p in ((0, start.translation), (1.5, goal.translation))
    ]
    inputs, out = tmp_path / "in.csv", tmp_path / "out.csv"
    inputs.write_text("\n".join(("# a person", "t,x,y,z,qw,qx,qy,qz", *lines, "")), encoding="utf-8")
    run(capsys, "--seconds", "4", "--inputs", str(inputs), "--csv", str(out))
    settings, _, rows = read(out)
    assert settings["inputs"] == "in.csv"
    pin.framesForwardKinematics(room.model, data, np.array([float(rows[-1][name]) for name in JOINTS[:14]]))
    assert np.abs(pin.log6(data.oMf[hand].actInv(goal)).vector).max() < 2e-3


def test_every_setting_can_be_given(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    words = """
        scene=hold rig=table robot=panda guided=left avoid=both following=identical path=circle point=arm ball=cross clip=wave
        kx=2 task=pose k=1.5 wmax=0.4 dt=0.01 g=8 seed=7 law=smooth_priority pairs=single dm=0.1 n=10 v=0.5 beta=80 d0=0.25
        eta=0.01 gamma=4 kr=3 bounds=null_space start=between eps=0.0002 dead=0.02 lag=0.03 qnoise=0.001 qstep=0.001 fps=30 dnoise=0.002
        curve=0.1:1,0.2:0 lever=0.4 first=tip together=stages load=3"""
    given = {key: text for key, _, text in (word.partition("=") for word in words.split())}
    flags = {"ff": "True", "one_sided": "True", "coupled": "True", "world": "True"}
    assert set(given) | set(flags) == set(specs(RunSettings))
    out = tmp_path / "out.csv"
    options = [part for key, text in given.items() for part in (f"--{key}", text)]
    run(
        capsys,
        "--seconds",
        "0.5",
        *options,
        *(f"--{key.replace('_', '-')}" for key in flags),
        "--csv",
        str(out),
    )
    settings, _, rows = read(out)
    assert len(rows) == 50
    for key, text in (given | flags).items():
        assert settings[key] == text or float(settings[key]) == float(text), key


LONG = "0.1," * 100
"""Longer than a file name may be."""

ERRORS = {
    "run --dm 9": "dm = |0.03|0.3",
    "run --dm nan": "dm = |0.03",
    "run --dm wide": "dm = 'wide'|0.03",
    "run --law strict": "law = 'strict'|smooth_priority|unprotected",
    "run --curve 0.2:1,0.1:0": "0.2 comes before 0.1",
    "run --lever 1.2": "lever = '1.2'|0 to 1",
    "run --curve falling": "curve = 'falling'|0.15:1",
    "run --seed 1.5": "seed = '1.5'|whole number",
    "run --seconds 0": "seconds = 0|above 0 and up to 5000.",
    "run --seconds nan": "seconds = nan|5000.",
    "run --seconds -3": "seconds = -3|5000.",
    "run --seconds inf": "seconds = inf|5000.",
    "run --seconds 6000": "seconds = 6000|above 0 and up to 5000 (or a larger dt).",
    "run --inputs {}/hand.csv --csv {}/hand.csv": "hand.csv: the run reads this file|give another name",
    "run --inputs /no/such/file.csv": "/no/such/file.csv|cannot be read",
    "run --csv /no/such/folder/out.csv": "/no/such/folder|make it first",
    "run --csv {}": "cannot be written",
    "run --inputs {}": "cannot be read",
    "run --inputs {}/short.csv": "short.csv|line 1|t,x,y,z",
    "run --inputs {}/zero.csv": "zero.csv|line 2|'zero'",
    "run --inputs {}/noise.csv": "noise.csv|not a text",
    "serve --sessions 0": "--sessions must be at least 1, or auto",
    "serve --key chalk-dust --port 70000": "key has fewer than 12 characters|--key auto",
    "serve --n 0": "n = |1 to 20",
    "serve --theme pink": "theme = 'pink'|light|dark",
    "serve --port 70000": "port 70000",
    "serve --port 0 --host no.such.host.invalid": "no.such.host.invalid|127.0.0.1",
    "serve --port 0 --allow-origin duet.example.org": "duet.example.org|https://",
    "serve --allow-origin https://b.org/duet": "'https://b.org/duet' has a path|give https://b.org",
    **dict.fromkeys((f"run --start {LONG}", f"run --csv {LONG}/a.csv"), LONG),
}


@pytest.mark.parametrize("arguments", ERRORS)
def test_one_line_says_what_is_wrong(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, arguments: str
) -> None:
    assert_said(capsys, tmp_path, arguments, ERRORS[arguments], ())


def assert_said(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    arguments: str,
    parts: str,
    features: Sequence[Feature] = FEATURES,
) -> None:
    """Check that a command is refused with a line that contains `parts`. {}: a folder with some files."""
    for name, content in (
        ("short", b"t,x,y\n0,0,0\n"),
        ("zero", b"t,x,y,z\n0,0.3,zero,1\n"),
        ("noise", bytes(range(256))),
        ("hand", b"t,x,y,z\n0,0.3,0.1,1\n"),
    ):
        (tmp_path / f"{name}.csv").write_bytes(content)
    line = refused(capsys, *arguments.replace("{}", str(tmp_path)).split(), features=features)
    assert all(part in line for part in parts.split("|")), line


def test_a_busy_port_names_the_port_and_the_remedy(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as holder:
        port = holder.getsockname()[1]
        line = refused(capsys, "serve", "--no-open", "--port", str(port), features=())
    assert str(port) in line and f"--port {port % 65535 + 1}" in line


@pytest.mark.parametrize("arguments", [[], ["serve"], ["--no-open"], ["--port", "9000", "--rig", "table"]])
def test_no_command_means_serve(monkeypatch: pytest.MonkeyPatch, arguments: list[str]) -> None:
    seen: list[Serve] = []
    monkeypatch.setattr("app.cli.main.serve", lambda command, features: seen.append(command) or 0)
    assert main(arguments) == 0
    (command,) = seen
    assert (command.host, command.sessions, command.key) == ("127.0.0.1", "auto", None)
    assert command.port == (9000 if "9000" in arguments else "auto")
    assert command.open is ("--no-open" not in arguments)
    assert values(settings_of_options(command.settings, Settings()))["rig"] == (
        "table" if "table" in arguments else "torso"
    )


def test_serve_opens_the_page_and_ends_with_ctrl_c(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    opened: list[str] = []

    def wait(app: App) -> None:
        with urllib.request.urlopen(app.url, timeout=60) as answer:
            opened.append(str(answer.status))
        raise KeyboardInterrupt

    monkeypatch.setattr(webbrowser, "open", lambda link: opened.append(link))
    monkeypatch.setattr(App, "wait", wait)
    assert command_line(["serve", "--port", "0", "--key", "auto"], ()) == INTERRUPTED
    link, status = opened
    assert link.startswith("http://127.0.0.1:") and len(link.partition("/?key=")[2]) >= SHORTEST
    assert "key=auto" not in link and status == "200"
    said = capsys.readouterr().out
    assert link in said and re.search(r"This machine carries about [1-9]\d* sessions at once\.", said)
    # A given key must not appear in the log of a service.
    monkeypatch.setenv("DUET_KEY", "chalk-and-talk")
    for given in (["--key", "white-chalk-dust"], []):
        assert command_line(["serve", "--port", "0", *given], ()) == INTERRUPTED
        given_link, said = opened[-2], capsys.readouterr().out
        assert (
            given_link.endswith("/?key=" + (given[-1] if given else "chalk-and-talk")) and "chalk" not in said
        )
        assert "/?key=KEY\n" in said
    monkeypatch.delenv("DUET_KEY")
    port = int(link.split(":")[2].split("/")[0])
    with socket.socket() as probe:
        assert probe.connect_ex(("127.0.0.1", port)) != 0, "the port is still served"
    assert command_line(["serve", "--port", "0", "--no-open", "--sessions", "3"], ()) == INTERRUPTED
    assert len(opened) == 7 and "carries" not in capsys.readouterr().out


@pytest.fixture
def ended_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Servers use a free port, end at once, and open no browser."""

    def wait(app: App) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(webbrowser, "open", lambda link: None)
    monkeypatch.setattr(App, "wait", wait)
    monkeypatch.setattr("app.cli.serve.USUAL_PORT", free_port())
    # Also with --host 0.0.0.0, only this computer can reach a test's server.
    monkeypatch.setattr("app.cli.serve.listen_near", lambda host, port: listen_near("127.0.0.1", port))


TIP = EXPERIMENT_TEXTS[HOLD](RunSettings(), True).tip


@pytest.mark.usefixtures("ended_at_once")
def test_without_options_it_prints_the_address_a_tip_and_how_to_end(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert command_line([], ()) == INTERRUPTED
    out, err = capsys.readouterr()
    address, *others = out.splitlines()
    assert re.fullmatch(r"Duet is at http://127\.0\.0\.1:\d+", address)
    assert others == [TIP, "Ctrl+C ends it."] and err == ""
    assert TIP.count(".") == 1 and len(TIP.split()) <= 20


@pytest.mark.usefixtures("ended_at_once")
def test_the_printed_tip_is_the_pages_tip_for_the_experiment(capsys: pytest.CaptureFixture[str]) -> None:
    assert command_line(["--scene", "ball", "--point", "elbow", "--no-autopilot"], ()) == INTERRUPTED
    expected = EXPERIMENT_TEXTS[BALL](changed(RunSettings(scene=BALL), "point", "elbow"), False).tip
    assert capsys.readouterr().out.splitlines()[1:] == [expected, "Ctrl+C ends it."]


@dataclass(frozen=True)
class MadeUpClass(FeatureOptions):
    """A class."""

    for_all: bool = False
    """All tabs see one session."""

    @property
    def shared_by(self) -> str:
        return "--for-all" if self.for_all else ""

    def said_at_start(self, host: str, port: int, places: int) -> tuple[str, ...]:
        return (f"The class opens {host}.",) if self.for_all else ()


FOR_OTHERS = [
    "--host 0.0.0.0",
    "--allow-origin https://duet.example.org",
    "--embed-origin https://moodle.example.org",
    "--key auto",
]


@pytest.mark.usefixtures("ended_at_once")
@pytest.mark.parametrize("others", FOR_OTHERS)
def test_a_start_open_to_others_prints_the_number_of_sessions(
    capsys: pytest.CaptureFixture[str], others: str
) -> None:
    assert command_line(others.split(), ()) == INTERRUPTED
    said = capsys.readouterr().out.splitlines()
    assert re.fullmatch(r"This machine carries about [1-9]\d* sessions at once\.", said[1])
    assert said[2:] == [TIP, "Ctrl+C ends it."]
    assert command_line([*others.split(), "--sessions", "3"], ()) == INTERRUPTED
    assert len(capsys.readouterr().out.splitlines()) == 3


@pytest.mark.usefixtures("ended_at_once")
def test_a_features_text_at_the_start_is_below_the_address(
    capsys: pytest.CaptureFixture[str],
) -> None:
    feature = Feature("made_up", options=lambda: MadeUpClass)
    assert command_line(["--sessions", "3", "--for-all"], (feature,)) == INTERRUPTED
    said = capsys.readouterr().out.splitlines()
    assert said[1:] == ["The class opens 127.0.0.1.", TIP, "Ctrl+C ends it."]
    assert command_line([], (feature,)) == INTERRUPTED
    assert len(capsys.readouterr().out.splitlines()) == 3


@pytest.mark.usefixtures("ended_at_once")
def test_a_taken_port_is_reported_in_a_separate_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        taken = other.getsockname()[1]
        monkeypatch.setattr("app.cli.serve.USUAL_PORT", taken)
        assert command_line([], ()) == INTERRUPTED
    address, port, *_ = said = capsys.readouterr().out.splitlines()
    assert len(said) == 4 and str(taken) not in address
    assert port.startswith(f"Port {taken} is taken by another program")


SERVE = ["--host", "--port", "--no-open", "--key", "--scene", "--law", "--help-all"]
SERVE_ALL = [*SERVE[:-1], "--sessions", "--allow-origin", "--theme", "--dm"]
RUN = [
    "--seconds",
    "--inputs",
    "--csv",
    "--seed",
    "--law",
    "--pairs",
    "--rig",
    "--dm",
    "--dt",
    "0.03 to 0.3 m",
]
HELP = {
    "serve --help": SERVE,
    "serve --help-all": SERVE_ALL,
    "run --help": RUN,
}


def test_the_app_gets_all_options_of_the_command(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    served: list[ServeOptions] = []

    def start(options: ServeOptions, *_: object, **__: object) -> App:
        served.append(options)
        raise KeyboardInterrupt

    monkeypatch.setattr("app.start.start_app", start)
    assert command_line(["serve", *every_option()], ()) == INTERRUPTED
    usual, (one,) = ServeOptions(), served
    equal = {each.name for each in fields(usual) if getattr(one, each.name) == getattr(usual, each.name)}
    assert equal == {"features", "loops", "proof"}
    monkeypatch.setenv("DUET_PROOF", "of-the-tile")
    assert command_line(["serve"], ()) == INTERRUPTED
    assert served[1].proof == "of-the-tile"
    # Processes that features start must not inherit it.
    assert "DUET_PROOF" not in os.environ


@pytest.mark.parametrize(
    ("words", "world", "as_usual"),
    [
        ([], False, True),
        (["--world"], True, True),
        (["--no-world"], False, False),
        (["--no-world", "--rig", "table"], False, False),
    ],
)
def test_a_default_page_glides_unless_a_server_option_forbids_it(
    words: list[str], world: bool, as_usual: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[Serve] = []
    monkeypatch.setattr("app.cli.main.serve", lambda command, features: seen.append(command) or 0)
    assert main(["serve", *words]) == 0
    (command,) = seen
    assert settings_of_options(command.settings, Settings()).run.world is world
    assert glides_as_usual(command.settings) is as_usual


def test_world_and_no_world_exclude_each_other(capsys: pytest.CaptureFixture[str]) -> None:
    assert "give one of them" in refused(capsys, "serve", "--no-open", "--world", "--no-world", features=())


def every_option() -> list[str]:
    """Every option of `serve` that is valid with several processes."""
    others = "--sessions 3 --dm 0.2 --no-world --key chalk-and-talk --host 127.0.0.2"
    here = ["--port", str(free_port()), "--allow-origin", "https://duet.example.org"]
    here += ["--embed-origin", "https://moodle.example.org"]
    return [*others.split(), *here]


@pytest.mark.parametrize("command", HELP)
def test_help(command: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    with pytest.raises(SystemExit) as end:
        main(command.split())
    said = capsys.readouterr()
    assert [part for part in HELP[command] if part not in said.out] == [] and (end.value.code, said.err) == (
        0,
        "",
    )


def test_the_command_line_loads_no_heavy_library() -> None:
    code = "import sys, app.cli.main; print(*sorted({'matplotlib', 'numpy', 'pinocchio', 'viser', 'trimesh', 'mujoco'} & set(sys.modules)))"
    command, root = [sys.executable, "-c", code], Path(__file__).parents[3]
    done = subprocess.run(command, capture_output=True, timeout=60, check=True, cwd=root)
    assert (done.stdout.strip(), done.stderr) == (b"", b"")


def test_every_setting_is_an_option_and_a_link_key_with_the_same_values() -> None:
    options = all_options()
    assert list(options.__dataclass_fields__) == [*specs(Settings), *PLACES, NO_WORLD]
    assert list(RunOptions.__dataclass_fields__) == [*specs(RunSettings), *PLACES]
    assert (
        settings_of_options(options(), Settings()) == Settings()
        and settings_of_options(RunOptions(), RunSettings()) == RunSettings()
    )
    for key, spec in specs(Settings).items():
        present = values(Settings())[key]
        if spec.choices:
            text = spec.choices[spec.choices.index(present) - 1]
        elif spec.read is not None:
            text = "0.1:1,0.2:0"
        else:
            other = (
                not present if isinstance(present, bool) else spec.low if present != spec.low else spec.high
            )
            text = f"{other:g}"
        from_link, problems = from_query({key: text}, Settings())
        option: Any = text == "1" if isinstance(present, bool) else text
        from_option = settings_of_options(options(**{key: option}), Settings())
        assert problems == () and from_link == from_option, key
        assert values(from_link)[key] != present or len(spec.choices) == 1, key
