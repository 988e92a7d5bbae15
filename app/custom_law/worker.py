"""The process of a student's law: `python -m app.custom_law.worker LINE MEMORY PATH`. It says that it is up, gets the file, then answers.

Nothing that the file prints gets anywhere, nothing that it does reaches the page but by its answers, and it goes when the page goes.
This keeps mistakes apart, not malice: whoever may write the file may do whatever the user may.
"""

import faulthandler
import os
import signal
import socket
import struct
import sys
import threading

from app.custom_law.law_file import LawFile, Wrong
from app.custom_law.wire import (
    BROKEN,
    LawConnection,
    QuestionKind,
    ReplyKind,
    pack_answer,
    pack_failure,
    unpack_activation,
    unpack_activations,
    unpack_rates,
    unpack_situation,
)


def main() -> None:
    """Serve until the line is hung up."""
    line_number, memory, path = sys.argv[1], int(sys.argv[2]), sys.argv[3]
    line = LawConnection(_end_of(line_number))
    _mute()
    _limit(memory)
    # A neighbour of the file may be imported, but it cannot take the place of a library.
    sys.path.append(os.path.dirname(path))
    try:
        line.send(pack_answer(ReplyKind.UP))
        _serve(line, path, memory)
    except EOFError:
        pass
    except OSError:
        # The file closed it, or the page is gone.
        sys.exit(BROKEN)


def _end_of(name: str) -> socket.socket:
    """Return this end of the line: an inherited descriptor, or on Windows what is written to the standard input."""
    if name != "share":
        # The lowest number that is free, however many files the page has open.
        with socket.socket(fileno=int(name)) as end:
            return end.dup()
    size = int.from_bytes(sys.stdin.buffer.read(4), "little")
    return socket.fromshare(sys.stdin.buffer.read(size))  # type: ignore[attr-defined]


def _mute() -> None:
    """Let nothing in or out but over the line, and leave if the parent goes, even in the middle of an endless loop.

    The parent reads from the old standard error where a crash, or a call that it has lost patience with, was under way.
    """
    trace, life = os.dup(2), os.dup(0)
    nothing = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nothing, stream)
    faulthandler.enable(trace)
    if hasattr(faulthandler, "register"):
        faulthandler.register(signal.SIGUSR1, trace)

    def leave_with_parent() -> None:
        while os.read(life, 64):
            pass
        os._exit(0)

    threading.Thread(target=leave_with_parent, daemon=True).start()


def _limit(memory: int) -> None:
    """Allow so much more memory than is in use now [bytes], where the system can count it."""
    try:
        import resource

        with open("/proc/self/statm", encoding="ascii") as file:
            used = int(file.read().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + memory, used + memory))
        # A crash is reported, not kept.
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    except (ImportError, OSError, ValueError):
        pass


def _serve(line: LawConnection, path: str, memory: int) -> None:
    law: LawFile | None = None
    while (body := line.receive(None)) is not None:
        try:
            if body[0] == QuestionKind.LOAD:
                law = LawFile(path, body[1:], memory)
                answer = pack_answer(ReplyKind.DONE, bytes((law.wants_all_pairs, law.has_activation)))
            else:
                assert law is not None
                answer = _answer(law, body)
        except Wrong as wrong:
            answer = pack_answer(ReplyKind.FAILED, pack_failure(wrong.text, wrong.line))
        line.send(answer)


def _answer(law: LawFile, body: bytes) -> bytes:
    match body[0]:
        case QuestionKind.LAW:
            velocities, seconds = law.velocities(unpack_situation(body))
            return pack_answer(ReplyKind.DONE, velocities.tobytes(), seconds)
        case QuestionKind.ACTIVATION:
            return pack_answer(ReplyKind.DONE, struct.pack("<d", law.activation(unpack_activation(body))))
        case QuestionKind.ACTIVATIONS:
            return pack_answer(ReplyKind.DONE, law.activations(unpack_activations(body)).tobytes())
        case _:
            return pack_answer(ReplyKind.DONE, law.rates(*unpack_rates(body)).tobytes())


if __name__ == "__main__":
    main()
