"""A law of one's own in the head of a table."""


def law_heading(file: str, sha256: str) -> dict[str, str]:
    """Return what the head of a table says of a law of one's own in place of the settings' law: its file, as it was at the end."""
    return {"law": file, "law_sha256": sha256}
