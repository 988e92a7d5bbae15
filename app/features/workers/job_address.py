"""Address and start of the shared job pool. Imports nothing slow."""

import subprocess
from pathlib import Path
from typing import NamedTuple

from controllers.own_packages import own_command


class JobAddress(NamedTuple):
    """Path of a Unix socket, and a secret."""

    path: str
    secret: bytes


def start_job_server(address: JobAddress) -> "subprocess.Popen[bytes]":
    """The server ends when its standard input is closed."""
    # An earlier one may have been killed.
    Path(address.path).unlink(missing_ok=True)
    process = subprocess.Popen(
        own_command("app.features.workers.shared_jobs"), stdin=subprocess.PIPE, process_group=0
    )
    assert process.stdin is not None
    process.stdin.write(f"{address.path} {address.secret.hex()}\n".encode())
    process.stdin.flush()
    return process
