"""How much one browser may ask for."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Limits:
    """How much one browser may ask for.

    Attributes:
        text_bytes: longest text that may be typed into one field.
        upload_bytes: largest file, and the sum of all unfinished ones of a browser.
        uploads: files under way at the same time.
        messages_per_second: what is beyond is read later, so the sender is slowed down; a lively person sends about 100.
        frame_bytes: largest single websocket message.
        stall_seconds: a browser that reads nothing for this long is taken for gone.
    """

    text_bytes: int = 100_000
    upload_bytes: int = 20_000_000
    uploads: int = 4
    messages_per_second: float = 600.0
    frame_bytes: int = 16 * 1024 * 1024
    stall_seconds: float = 45.0
