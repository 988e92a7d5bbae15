"""Whose a file is, and whether it is the template; the marks themselves are in `tests/app/custom_law/test_marking.py`."""

from pathlib import Path

import app
from app.marks.graded_file import Student, is_template, returned_line, student_of


def test_what_a_file_is_and_whose() -> None:
    names = {"Jo/law.py": ("Jo", ""), "law.py": ("law", ""), "doejo_LATE_5_6_a-1.py": ("doejo", "5"), "a_b.py": ("a_b", "")}
    assert {name: student_of(Path(name)) for name in names} == {name: Student(*known) for name, known in names.items()}
    template = Path(app.__file__).with_name("custom_law").joinpath("template.py").read_bytes()
    assert is_template(template + b"\n# more") and not is_template(template.replace(b"0.30", b"0.31"))
    assert not is_template(b"def law(") and returned_line(b"def law(") == returned_line(b"law = 3") == ()
