"""A law of one's own in the head of a table."""


def law_heading(file: str, sha256: str) -> dict[str, str]:
    """Lines of a table's head for a law from a file, in place of the settings' law; the file as it was at the end."""
    return {"law": file, "law_sha256": sha256}
