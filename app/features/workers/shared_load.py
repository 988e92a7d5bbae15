"""Load of all processes."""

from collections.abc import Sequence

from app.page.panels.server_load import ServerLoad
from app.start import App


def combined(loads: Sequence[ServerLoad]) -> ServerLoad:
    """Frames of the slowest, all sessions and places, load of the busiest."""
    frames, sessions, places, load = zip(*loads, strict=True)
    return ServerLoad(min(frames), sum(sessions), sum(places), max(load))


class LoadOfAll:
    """Adds other processes to this one's `/healthz`."""

    def __init__(self, app: App) -> None:
        self._workload, self._of_this, self._elsewhere = (
            app.context.workload,
            app.server.app_state,
            list[ServerLoad](),
        )
        app.server.app_state = lambda: {**self._of_this(), **self.everywhere._asdict()}

    def note(self, reports: Sequence[tuple[int, ...]]) -> None:
        """`reports`: see `worker_messages.Load`."""
        self._elsewhere = [ServerLoad(*report) for report in reports]

    @property
    def everywhere(self) -> ServerLoad:
        """A process that has drawn nothing yet does not count as the slowest."""
        reports = [self._workload.report, *self._elsewhere]
        return combined([one for one in reports if one.frames] or reports)
