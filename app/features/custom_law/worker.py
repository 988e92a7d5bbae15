"""The process of a custom law; arguments: CONNECTION MEMORY PATH.

It discards the file's output, and ends with the page. This protects against mistakes, not malice: a file's
author can do what the user can do.
"""

import faulthandler
import os
import signal
import sys
import threading
from multiprocessing import connection

import numpy as np

from app.features.custom_law import wire
from app.features.custom_law.law_file import LawFile, Wrong


def main() -> None:
    line, memory, path = _inherited(int(sys.argv[1])), int(sys.argv[2]), sys.argv[3]
    _mute()
    _limit(memory)
    # The file may import a neighbour, but not replace a library.
    sys.path.append(os.path.dirname(path))
    try:
        line.send_bytes(wire.encode(wire.Started()))
        _serve(line, path, memory)
    except EOFError:
        pass
    except OSError:
        # The file closed it, or the page is gone.
        sys.exit(wire.BROKEN)


def _inherited(handle: int) -> "connection.Connection":
    if os.name == "nt":
        return connection.PipeConnection(handle)  # pyright: ignore[reportAttributeAccessIssue]
    # The lowest free number, however many files the page has open.
    lowest = os.dup(handle)
    os.close(handle)
    return connection.Connection(lowest)


def _mute() -> None:
    """Discard the standard streams, and end with the parent, even in an endless loop.

    The parent reads the old standard error after a crash or a late call.
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
    """Limit the memory to the current use plus `memory` [bytes], where supported."""
    try:
        import resource

        with open("/proc/self/statm", encoding="ascii") as file:
            used = int(file.read().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + memory, used + memory))
        # No core dumps.
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    except (ImportError, OSError, ValueError):
        pass


def _serve(line: "connection.Connection", path: str, memory: int) -> None:
    law: LawFile | None = None
    while True:
        question = wire.decode_question(line.recv_bytes())
        try:
            if isinstance(question, wire.LoadFile):
                law = LawFile(path, question.text, memory)
                reply = wire.FileLoaded(law.wants_all_pairs, law.has_activation)
            else:
                assert law is not None
                reply = _answer(law, question)
        except Wrong as wrong:
            reply = wire.Failure(wire.TextParts.of(wrong.text), wrong.line)
        line.send_bytes(wire.encode(reply))


def _answer(law: LawFile, question: wire.LawQuestion) -> wire.Numbers:
    if isinstance(question, wire.VelocityQuestion):
        velocities, seconds = law.velocities(question.situation())
        return wire.Numbers(velocities.tobytes(), seconds)
    if isinstance(question, wire.ActivationQuestion):
        return wire.Numbers(np.float64(law.activation(question.distance)).tobytes())
    distances = np.frombuffer(question.distances)
    if isinstance(question, wire.ActivationsQuestion):
        return wire.Numbers(law.activations(distances).tobytes())
    return wire.Numbers(law.rates(distances, question.pull, question.approach, question.square).tobytes())
