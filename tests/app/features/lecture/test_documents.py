"""The documents for teachers."""

import re

from app.features.lecture import LECTURE
from tests.test_imports import ROOT


def test_the_documents_for_teachers_have_valid_options_and_times() -> None:
    plan = LECTURE.documents["lecture-plan"].file.read_text(encoding="utf-8")
    assert set(re.findall(r"--([a-z][a-z-]+)", plan)) <= {"lecture", "key", "profile", "sessions", "host"}
    for part, whole in zip(plan.split("## In 45 minutes"), (90, 45), strict=True):
        rows = [row.split("|") for row in part.splitlines() if re.match(r"\| \d:\d\d ", row)]
        minutes = [int(row[2]) for row in rows]
        assert sum(minutes) == whole and "".join(row[4] for row in rows).count("↻") == 2
        begins = [60 * int(row[1].split(":")[0]) + int(row[1].split(":")[1]) for row in rows]
        assert begins == [sum(minutes[:i]) for i in range(len(rows))]
    command = "lwr-duet serve --lecture --key auto --profile projector --host 0.0.0.0"
    assert all(command in one.file.read_text(encoding="utf-8") for one in LECTURE.documents.values())
    assert command in (ROOT / "README.md").read_text(encoding="utf-8")
