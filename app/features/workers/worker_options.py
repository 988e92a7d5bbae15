"""The option of `lwr-duet serve` for several processes. Imports nothing slow."""

import socket
from dataclasses import dataclass
from typing import Final, Literal

from app.hosting.serve_options import FeatureOptions, ServeOptions
from app.runtime.progress import cores
from controllers.errors import BadSetting

MOST_WORKERS: Final = 8
"""Most processes of `--workers auto`."""


@dataclass(frozen=True)
class WorkerOptions(FeatureOptions):
    """Several processes."""

    workers: int | Literal["auto"] = "auto"
    """Processes that share the visitors, started as they are needed; `auto` for as many as the machine has cores."""

    def check(self) -> None:
        if self.workers != "auto" and self.workers < 1:
            raise BadSetting("--workers must be at least 1.")

    def count(self, options: ServeOptions) -> int:
        """Processes that may share the visitors.

        Raises:
            BadSetting: the option asks for more than one, and only one is possible.
        """
        reasons = [one.one_process for one in options.features if one.one_process]
        if not hasattr(socket, "send_fds"):
            reasons.append("this system cannot hand connections over")
        reason = reasons[0] if reasons else ""
        if self.workers == "auto":
            return 1 if reason else min(cores(), MOST_WORKERS)
        if reason and self.workers > 1:
            raise BadSetting(f"--workers must be 1 here: {reason}.")
        return self.workers
