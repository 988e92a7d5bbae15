"""The errors for messages that are not let through."""

from typing import Final

UPLOAD_TOO_LARGE: Final = "upload too large"


class Malformed(Exception):
    """The message can't have come from viser's own client; close the connection."""


class Refused(Exception):
    """The message is understood but not allowed; drop it. `kind` groups the log lines."""

    def __init__(self, kind: str) -> None:
        super().__init__(kind)
        self.kind = kind
