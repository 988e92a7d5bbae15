"""Every command in a separate process: Ctrl+C, a closed or full output, and a locale without UTF-8."""

import errno
import os
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Final, NamedTuple
from urllib.parse import quote
from urllib.request import urlopen

import pytest

from app.__main__ import run_command as main
from app.runtime.terminal import INTERRUPTED
from tests.app.runtime.processes import PATIENCE, gone, until

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(os.name != "posix", reason="signals and descriptors as POSIX has them"),
]

ROOT: Final = Path(__file__).parents[3]
OURS: Final = tuple(str(ROOT / room) for room in ("app", "scenes", "controllers"))
# If the tests run in the background, their child processes would inherit that Ctrl+C is ignored.
HEARS: Final = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
ENTRY: Final = HEARS + "from app.__main__ import entry; entry()"
VISITOR: Final = f"""{HEARS}
def visitor():
    from app.features.bench.visitor import measure_visitor
    measure_visitor(60.0)
from app.runtime.terminal import run_in_terminal
raise SystemExit(run_in_terminal(visitor))
"""
EVERY: Final = """
import sys
from itertools import groupby
from app.__main__ import run_command as main
def run_all():
    for apart, arguments in groupby(sys.argv[1:], lambda one: one == ";"):
        if not apart:
            try:
                code = main(list(arguments))
            except SystemExit as end:
                code = end.code
            print("code", code, flush=True)
    return 0
from app.runtime.terminal import run_in_terminal
raise SystemExit(run_in_terminal(run_all))
"""
C_LOCALE: Final = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
MARK = """
import os
_law = law
def law(situation):
    with open("begun", "w") as out:
        out.write(str(os.getpid()))
    os.rename("begun", "calls")
    return _law(situation)
"""
COMPLAINT: Final = re.compile(r"lwr-duet: |Traceback|Exception ignored|[\w.]+(Error|Exception)\b")
"""Beginning of a complaint of Duet or Python. Warnings of other packages depend on their versions."""
FOREIGN_WARNING: Final = re.compile(r"^(?P<file>\S.*?):\d+: \w*Warning: .*\n(?:  .*\n)?", re.MULTILINE)
Process = subprocess.Popen[bytes]
Moment = Callable[[Process, Path], object]


@contextmanager
def started(
    command: Sequence[str], folder: Path, more: Mapping[str, str] = {}
) -> Iterator[tuple[Process, Path]]:
    """A command in its own process group, and its stderr file. `more`: environment variables."""
    said = folder / "stderr"
    with said.open("wb") as errors:
        process = subprocess.Popen(
            [sys.executable, *command],
            stdout=subprocess.PIPE,
            stderr=errors,
            cwd=ROOT,
            env=os.environ | more,
            start_new_session=True,
            bufsize=0,
        )
    try:
        yield process, said
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def complaints(said: str) -> list[str]:
    return [line for line in said.splitlines() if COMPLAINT.match(line)]


def own_words(said: str) -> str:
    """stderr without warnings about files of other packages."""
    return FOREIGN_WARNING.sub(lambda warning: warning[0] if warning["file"].startswith(OURS) else "", said)


def in_utf_8(text: str) -> str:
    """An argument that reaches a process as UTF-8, also if the tests run in another locale."""
    return os.fsdecode(text.encode())


def group(number: int) -> list[int]:
    found: list[int] = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            state, _, of = stat.read_text(encoding="utf-8", errors="replace").rsplit(")", 1)[1].split()[:3]
            if int(of) == number and state not in "ZX":
                found.append(int(stat.parent.name))
    return found


def importing(module: str) -> Moment:
    seen = re.compile(rf"\| +{re.escape(module)}\n")
    return lambda process, folder: until(
        lambda: seen.search((folder / "stderr").read_text(encoding="utf-8")), process
    )


def there(name: str) -> Moment:
    return lambda process, folder: until((folder / name).exists, process)


def members(count: int) -> Moment:
    return lambda process, folder: until(lambda: len(group(process.pid)) >= count, process)


def answering(process: Process, folder: Path) -> None:
    out: IO[bytes] | None = process.stdout
    assert out is not None
    address = out.readline()
    assert b"Duet is at" in address
    assert out.readline().endswith(b".\n") and out.readline() == b"Ctrl+C ends it.\n"
    # A signal during the last write would repeat the line.
    with urlopen(address.split()[3].decode(), timeout=PATIENCE) as answer:
        assert answer.status == 200


def reading_heads(process: Process, folder: Path) -> list[socket.socket]:
    """100 connections with incomplete requests, which the server reads repeatedly."""
    out: IO[bytes] | None = process.stdout
    assert out is not None
    port = int(out.readline().split()[3].decode().rpartition(":")[2])
    out.readline()
    out.readline()
    connections = [socket.create_connection(("127.0.0.1", port), timeout=PATIENCE) for _ in range(100)]
    for connection in connections:
        connection.sendall(b"GET / HTTP/1.1\r\nHost: ")
    return connections


INTERRUPTIONS: dict[str, tuple[list[str], Moment]] = {
    "before main": (
        ["-X", "importtime", "-c", ENTRY, "serve", "--no-open", "--store", "memory", "--port", "0"],
        importing("tyro.conf"),
    ),
    "serve, importing": (
        [
            "-X",
            "importtime",
            "-c",
            ENTRY,
            "serve",
            "--no-open",
            "--store",
            "memory",
            "--port",
            "0",
            "--workers",
            "1",
        ],
        importing("viser.infra._infra"),
    ),
    "serve": (
        ["-c", ENTRY, "serve", "--no-open", "--store", "memory", "--port", "0", "--workers", "2"],
        answering,
    ),
    "serve, reading": (
        ["-c", ENTRY, "serve", "--no-open", "--store", "memory", "--port", "0", "--workers", "2"],
        reading_heads,
    ),
    "run": (
        ["-c", ENTRY, "run", "--seconds", "4000", "--law-file", "{}/law.py", "--csv", "{}/out.csv"],
        there("calls"),
    ),
    "law-test": (["-c", ENTRY, "law-test", "{}/law.py"], there("calls")),
    "figures": (["-c", ENTRY, "figures", "--only", "2,5", "--out", "{}"], there("fig2_activation.csv")),
    "lessons": (
        ["-X", "importtime", "-c", ENTRY, "lessons", "--check"],
        importing("app.features.lessons.check"),
    ),
    "sweep": (
        [
            "-c",
            ENTRY,
            *["sweep", "--over", "seed=1:9", "--seconds", "4000", "--workers", "2", "--out", "{}/table"],
        ],
        members(3),
    ),
    "bench": (["-c", VISITOR], members(2)),
}


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="groups of processes are read from /proc")
@pytest.mark.parametrize("case", INTERRUPTIONS)
def test_ctrl_c_ends_a_command_silently_and_leaves_nothing(case: str, tmp_path: Path) -> None:
    command, moment = INTERRUPTIONS[case]
    assert main(["new-law", str(tmp_path / "law.py")]) == 0
    with (tmp_path / "law.py").open("a", encoding="utf-8") as law:
        law.write(MARK)
    with started([part.replace("{}", str(tmp_path)) for part in command], tmp_path) as (process, said):
        held = moment(process, tmp_path)
        # As in a terminal: the whole group gets the signal, and an impatient user presses twice.
        for _ in range(2):
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGINT)
        out, _ = process.communicate(timeout=PATIENCE)
        until(lambda: not group(process.pid))
    del held
    # At the first run on a machine, the log mentions the compilation of loops.
    unsaid = re.compile(r"import time:|[\d-]+ [\d:,]+ INFO duet\.")
    words = [
        line for line in own_words(said.read_text(encoding="utf-8")).splitlines() if not unsaid.match(line)
    ]
    assert process.returncode == INTERRUPTED, words
    assert out == b"" and len(words) == (1 if case == "sweep" else 0), (out, words)
    if (tmp_path / "calls").exists():
        until(lambda: gone(int((tmp_path / "calls").read_text(encoding="utf-8"))))
    # No draft and no incomplete file.
    left = {path.name for path in tmp_path.iterdir() if path.suffix in ("", ".py") or path.name == "out.csv"}
    assert left <= {"law.py", "calls", "begun", "stderr", "table", "__pycache__"}


def ended(command: Sequence[str | bytes], **options: object) -> subprocess.CompletedProcess[bytes]:
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options
    return subprocess.run(command, cwd=ROOT, timeout=PATIENCE, check=False, **options)  # type: ignore[call-overload]


OUTPUTS = [
    ["--help"],
    ["run", "--seconds", "0.05"],
    ["serve", "--no-open", "--store", "memory", "--port", "0"],
]


def program(arguments: Sequence[str]) -> list[str]:
    return [sys.executable, "-m", "app", *arguments]


@pytest.mark.thorough
@pytest.mark.parametrize("arguments", OUTPUTS, ids=" ".join)
def test_a_closed_pipe_is_not_an_error(arguments: list[str]) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    with open(writer, "wb") as out:
        done = ended(program(arguments), stdout=out)
    assert done.returncode == 0 and complaints(done.stderr.decode()) == [], done.stderr


@pytest.mark.thorough
def test_a_closed_output_is_not_an_error() -> None:
    run = program(["run", "--seconds", "0.05"])
    done = ended(["sh", "-c", 'exec "$@" <&- >&-', "sh", *run])
    assert done.returncode == 0 and complaints(done.stderr.decode()) == [], done.stderr


needs_full = pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")


# Not for the server: it ends in the same way for any lost output.
@needs_full
@pytest.mark.thorough
@pytest.mark.parametrize("arguments", OUTPUTS[:2], ids=" ".join)
def test_a_full_output_is_reported(arguments: list[str]) -> None:
    with open("/dev/full", "wb") as full:
        done = ended(program(arguments), stdout=full)
    assert done.returncode == 1
    full_device = f"lwr-duet: the output cannot be written ({os.strerror(errno.ENOSPC)})."
    assert complaints(done.stderr.decode()) == [full_device], done.stderr


@needs_full
@pytest.mark.thorough
def test_the_exit_code_is_right_if_stderr_is_full() -> None:
    with open("/dev/full", "wb") as full:
        assert ended(program(["run", "--dm", "9"]), stderr=full).returncode == 2


KEY: Final = in_utf_8("Küchentürschloss")


class Spoken(NamedTuple):
    """Output and files of commands in a locale without UTF-8.

    Attributes:
        lines: standard output.
        errors: stderr, without warnings about files of other packages.
    """

    lines: list[str]
    errors: str
    law: Path
    csv: Path
    odd: str


@pytest.fixture(scope="module")
def spoken(tmp_path_factory: pytest.TempPathFactory) -> Spoken:
    """Results of all commands, in one process because loading is slow."""
    folder = tmp_path_factory.mktemp("spoken")
    law, out = folder / in_utf_8("größe.py"), folder / in_utf_8("über.csv")
    # A name that is not valid in any locale.
    odd = os.fsdecode(os.fsencode(folder) + b"/\xff.py")
    sweep = ["sweep", "--over", "n=1:2", "--seconds", "0.1", "--workers", "1"]
    lessons = ["lessons", "--check", "--only", "strict-priority"]
    commands = [
        ["--help"],
        ["new-law", str(law)],
        ["new-law", odd],
        ["run", "--seconds", "0.1", "--law-file", str(law), "--csv", str(out)],
        ["law-test", str(law)],
        [*lessons, "--out", str(folder / "nochmal.json")],
        [*sweep, "--out", str(folder / in_utf_8("δ"))],
        ["run", "--inputs", str(folder / in_utf_8("ž.csv"))],
        ["serve", "--no-open", "--store", "memory", "--port", "0", "--key", KEY],
    ]
    every = ["-X", "warn_default_encoding", "-c", EVERY, *(part for one in commands for part in (*one, ";"))]
    with started(every, folder, C_LOCALE) as (process, errors):
        assert process.stdout is not None
        said: list[str] = []
        while not said or "Duet is at" not in said[-1]:
            said.append(process.stdout.readline().decode("utf-8", "surrogateescape"))
            assert said[-1], errors.read_text(encoding="utf-8")
        process.terminate()
        process.wait(PATIENCE)
    words = own_words(errors.read_text(encoding="utf-8", errors="surrogateescape"))
    return Spoken(said, words, law, out, odd)


@pytest.mark.thorough
def test_without_utf_8_every_command_has_the_right_exit_code(spoken: Spoken) -> None:
    assert "Traceback" not in spoken.errors and "EncodingWarning" not in spoken.errors, spoken.errors
    codes = [line for line in spoken.lines if line.startswith("code ")]
    assert codes == [f"code {code}\n" for code in (0, 0, 0, 0, 1, 0, 0, 2)], spoken.errors


@pytest.mark.thorough
def test_without_utf_8_every_command_prints_utf_8(spoken: Spoken) -> None:
    odd_in_utf_8 = os.fsencode(spoken.odd).decode("utf-8", "surrogateescape")
    text = "".join(spoken.lines) + spoken.errors
    assert [word for word in ("Žlajpah", "größe.py", odd_in_utf_8, "ž.csv", "d ≥") if word not in text] == []
    assert "\\u" not in text


@pytest.mark.thorough
def test_without_utf_8_files_are_written_in_utf_8(spoken: Spoken) -> None:
    assert "law(situation)" in Path(spoken.odd).read_text(encoding="utf-8")
    assert "größe.py" in spoken.law.read_text(encoding="utf-8")
    assert "# law = größe.py\n" in spoken.csv.read_text(encoding="utf-8")


@pytest.mark.thorough
def test_a_given_key_is_not_printed(spoken: Spoken) -> None:
    address = spoken.lines[-1]
    assert address.endswith("/?key=KEY\n")
    assert "Küchen" not in address and quote("Küchentürschloss") not in address
