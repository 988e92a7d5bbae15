"""How much one browser may ask for."""

from dataclasses import dataclass


@dataclass(frozen=True)
class TrafficLimits:
    """How much one browser may ask for.

    Attributes:
        text_bytes: longest text that may be typed into one field.
        upload_bytes: largest file, and the sum of all unfinished ones of a browser.
        uploads: files under way at the same time.
        messages_per_second: the rest is read later, which slows the sender down; a busy visitor sends about 100.
        bytes_per_second: the same for their size.
        message_bytes: largest message that is no part of a file.
        frame_bytes: largest single websocket message; viser's client cuts files into pieces of 512 kB.
        frames_waiting: websocket frames that are queued; the rest stays with the sender.
        small_frames_per_second: frames under 1 kB that end no message, such as pings; a connection that sends more is closed.
        connections: how many one tab may have at once, and one address for all pages without a tab's name.
        first_message_seconds: a connection that sends nothing for this long after it opened is closed.
        stall_seconds: a browser that reads nothing for this long is disconnected.
    """

    text_bytes: int = 100_000
    upload_bytes: int = 20_000_000
    uploads: int = 4
    messages_per_second: float = 600.0
    bytes_per_second: float = 4_000_000.0
    message_bytes: int = 256_000
    frame_bytes: int = 1_000_000
    frames_waiting: int = 4
    small_frames_per_second: float = 100.0
    connections: int = 8
    first_message_seconds: float = 10.0
    stall_seconds: float = 45.0
