"""Every command in a process of its own: Ctrl+C, an output that is closed or full, and a locale without UTF-8."""

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
from typing import IO, Final
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
# Where the tests run in the background, Ctrl+C is ignored, and would be by what they start.
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
"""How a line begins that Duet or Python complains in. Warnings of other packages depend on their versions, and are not promised."""
FOREIGN_WARNING: Final = re.compile(r"^(?P<file>\S.*?):\d+: \w*Warning: .*\n(?:  .*\n)?", re.MULTILINE)
Process = subprocess.Popen[bytes]
Moment = Callable[[Process, Path], object]


@contextmanager
def started(
    command: Sequence[str], folder: Path, more: Mapping[str, str] = {}
) -> Iterator[tuple[Process, Path]]:
    """A command in a group of its own, as a shell starts it; and the file that gets what it says on stderr. `more`: of the environment."""
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
    """What is on stderr, without the warnings about files of other packages."""
    return FOREIGN_WARNING.sub(lambda warning: warning[0] if warning["file"].startswith(OURS) else "", said)


def in_utf_8(text: str) -> str:
    """An argument that a process gets as UTF-8, also where the tests run in another locale."""
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
    # A signal in the very moment of the last write would write the line again.
    with urlopen(address.split()[3].decode(), timeout=PATIENCE) as answer:
        assert answer.status == 200


def reading_heads(process: Process, folder: Path) -> list[socket.socket]:
    """A hundred connections whose requests are not whole, so that the server looks at them again and again."""
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
def test_ctrl_c_ends_a_command_without_a_word_and_leaves_nothing(case: str, tmp_path: Path) -> None:
    command, moment = INTERRUPTIONS[case]
    assert main(["new-law", str(tmp_path / "law.py")]) == 0
    with (tmp_path / "law.py").open("a", encoding="utf-8") as law:
        law.write(MARK)
    with started([part.replace("{}", str(tmp_path)) for part in command], tmp_path) as (process, said):
        held = moment(process, tmp_path)
        # As a terminal does it: all of the group get the signal, and an impatient person presses twice.
        for _ in range(2):
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGINT)
        out, _ = process.communicate(timeout=PATIENCE)
        until(lambda: not group(process.pid))
    del held
    # On a machine where nothing has run yet, the log says that loops are compiled.
    unsaid = re.compile(r"import time:|[\d-]+ [\d:,]+ INFO duet\.")
    words = [
        line for line in own_words(said.read_text(encoding="utf-8")).splitlines() if not unsaid.match(line)
    ]
    assert process.returncode == INTERRUPTED, words
    assert out == b"" and len(words) == (1 if case == "sweep" else 0), (out, words)
    if (tmp_path / "calls").exists():
        until(lambda: gone(int((tmp_path / "calls").read_text(encoding="utf-8"))))
    # No draft, and nothing that is only begun.
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


@pytest.mark.thorough
@pytest.mark.parametrize("arguments", OUTPUTS, ids=" ".join)
def test_a_reader_that_has_gone_and_a_closed_output_are_no_mistake_and_a_full_one_is_named(
    arguments: list[str],
) -> None:
    command = [sys.executable, "-m", "app", *arguments]
    # The server's end is the same, whichever way its output is lost.
    reader, writer = os.pipe()
    os.close(reader)
    with open(writer, "wb") as out:
        done = ended(command, stdout=out)
    assert done.returncode == 0 and complaints(done.stderr.decode()) == [], done.stderr
    if arguments[0] == "serve":
        return
    if arguments[0] == "run":
        done = ended(["sh", "-c", 'exec "$@" <&- >&-', "sh", *command])
        assert done.returncode == 0 and complaints(done.stderr.decode()) == [], done.stderr
    if not Path("/dev/full").exists():
        pytest.skip("no device that is always full")
    with open("/dev/full", "wb") as full:
        done = ended(command, stdout=full)
        # The reason of a failure counts where it cannot be said, too.
        assert arguments[0] != "run" or ended([*command[:3], "run", "--dm", "9"], stderr=full).returncode == 2
    assert done.returncode == 1
    full_device = f"lwr-duet: the output cannot be written ({os.strerror(errno.ENOSPC)})."
    assert complaints(done.stderr.decode()) == [full_device], done.stderr


@pytest.mark.thorough
def test_without_utf_8_every_command_speaks_and_writes_it(tmp_path: Path) -> None:
    law, out, again = (
        tmp_path / in_utf_8("größe.py"),
        tmp_path / in_utf_8("über.csv"),
        tmp_path / "nochmal.json",
    )
    # A name that no locale reads is in the file, and was what could not be written.
    odd = os.fsdecode(os.fsencode(tmp_path) + b"/\xff.py")
    odd_in_utf_8 = os.fsencode(odd).decode("utf-8", "surrogateescape")
    commands = [
        ["--help"],
        ["new-law", str(law)],
        ["new-law", odd],
        ["run", "--seconds", "0.1", "--law-file", str(law), "--csv", str(out)],
        ["law-test", str(law)],
        ["lessons", "--check", "--only", "strict-priority", "--out", str(again)],
        [
            "sweep",
            "--over",
            "n=1:2",
            "--seconds",
            "0.1",
            "--workers",
            "1",
            "--out",
            str(tmp_path / in_utf_8("δ")),
        ],
        ["run", "--inputs", str(tmp_path / in_utf_8("ž.csv"))],
        ["serve", "--no-open", "--store", "memory", "--port", "0", "--key", in_utf_8("Küchentürschloss")],
    ]
    # In one process, as loading the program takes longer than most of them.
    every = ["-X", "warn_default_encoding", "-c", EVERY, *(part for one in commands for part in (*one, ";"))]
    with started(every, tmp_path, C_LOCALE) as (process, errors):
        assert process.stdout is not None
        said = []
        while not said or "Duet is at" not in said[-1]:
            said.append(process.stdout.readline().decode("utf-8", "surrogateescape"))
            assert said[-1], errors.read_text(encoding="utf-8")
        # A key that was given is not printed.
        assert (
            said[-1].endswith("/?key=KEY\n")
            and "Küchen" not in said[-1]
            and quote("Küchentürschloss") not in said[-1]
        )
        process.terminate()
        process.wait(PATIENCE)
    said_of_ours = own_words(errors.read_text(encoding="utf-8", errors="surrogateescape"))
    assert "Traceback" not in said_of_ours and "EncodingWarning" not in said_of_ours, said_of_ours
    codes = [line for line in said if line.startswith("code ")]
    assert codes == [f"code {code}\n" for code in (0, 0, 0, 0, 1, 0, 0, 2)], said_of_ours
    text = "".join(said) + said_of_ours
    assert (
        all(word in text for word in ("Žlajpah", "größe.py", odd_in_utf_8, "ž.csv", "d ≥"))
        and "\\u" not in text
    )
    assert "law(situation)" in Path(odd).read_text(encoding="utf-8")
    assert "größe.py" in law.read_text(encoding="utf-8") and "# law = größe.py\n" in out.read_text(
        encoding="utf-8"
    )
