"""Custom laws in tables."""


def law_heading(file: str, sha256: str) -> dict[str, str]:
    """Lines of a table's head that replace the settings' law; the file as it was at the end."""
    return {"law": file, "law_sha256": sha256}
