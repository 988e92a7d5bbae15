"""Tables in every form of spreadsheets and programs: equal samples, or a refusal with line and column."""

import random
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from controllers.errors import BadInputFile
from scenes.recording import POSE_HEADER, POSITION_HEADER, inputs_from
from scenes.roles import room_of
from scenes.settings import RunSettings
from scenes.starts import read_start

TIMES = [0.0, 0.05, 0.1]
PLACES = [[0.45, -0.3, 0.6], [0.45, -0.29, 0.6], [0.45, -0.28, 0.601]]
COMMA = "t,x,y,z\n0.0,0.45,-0.3,0.6\n0.05,0.45,-0.29,0.6\n0.1,0.45,-0.28,0.601\n"
SEMICOLON = COMMA.replace(",", ";").replace(".", ",")

READ: dict[str, str | bytes] = {
    "semicolons and decimal commas": SEMICOLON,
    "semicolons and points": COMMA.replace(",", ";"),
    "tabs": COMMA.replace(",", "\t"),
    "tabs and decimal commas": SEMICOLON.replace(";", "\t"),
    "bars": COMMA.replace(",", " | "),
    "blanks": COMMA.replace(",", "  "),
    "blanks and decimal commas": SEMICOLON.replace(";", " "),
    "blanks and units": COMMA.replace("t,x,y,z", "t [s] x [m] y [m] z [m]").replace(",", " "),
    "spaces after separators": COMMA.replace(",", ", "),
    "spaces and quotes": COMMA.replace(",", ", ").replace("t, x, y, z", '"t", "x", "y", "z"'),
    "mark of UTF-8": "\ufeff" + COMMA,
    "CRLF": SEMICOLON.replace("\n", "\r\n"),
    "CR": COMMA.replace("\n", "\r"),
    "UTF-16 of Excel": ("\ufeff" + SEMICOLON.replace(";", "\t")).encode("utf-16-le"),
    "UTF-16, high byte first": ("\ufeff" + COMMA).encode("utf-16-be"),
    "UTF-16 without a mark": COMMA.encode("utf-16-le"),
    "UTF-32": COMMA.encode("utf-32"),
    "quoted header": COMMA.replace("t,x,y,z", '"t","x","y","z"'),
    "everything in quotes": "\n".join(
        ",".join(f'"{cell}"' for cell in line.split(",")) for line in COMMA.split()
    ),
    "quoted decimal commas": "\n".join(
        ",".join(f'"{cell}"' for cell in line.split(";")) for line in SEMICOLON.split()
    ),
    "upper-case header": COMMA.replace("t,x,y,z", "T,X,Y,Z"),
    "units": COMMA.replace("t,x,y,z", "t [s],x [m],y [m],z [m]"),
    "units in brackets, without blanks": COMMA.replace("t,x,y,z", "t(s),x(m),y(m),z(m)"),
    "units after a stroke": COMMA.replace("t,x,y,z", "t/s,x/m,y/m,z/m"),
    "units after a line": COMMA.replace("t,x,y,z", "t_s,x_m,y_m,z_m"),
    "time": COMMA.replace("t,x", "Time,x"),
    "separator at each end": COMMA.replace("\n", ",\n"),
    "separators at the rows' ends": COMMA.replace("\n", ",,\n").replace("z,,", "z"),
    "blank lines and comments": "# by hand\n\n" + COMMA.replace("\n0.05", "\n\n# here\n0.05") + "\n\n",
    "lines of separators": SEMICOLON.replace("\n0,05", "\n;;;\n0,05") + ";;;\n",
    "comments as a spreadsheet keeps them": '"# a, b";;;\n# c;;;\n' + SEMICOLON,
    "comment in Latin-1": "# Größe\n".encode("latin-1") + COMMA.encode(),
    "the separator named": "sep=;\n" + SEMICOLON,
    "the separator named, with a mark and CRLF": "\ufeffsep=;\r\n" + SEMICOLON.replace("\n", "\r\n"),
    "header in a comment, as numpy has it": "# " + COMMA.replace(",", " "),
    "header in a comment, other separator": "# t,x,y,z\n" + COMMA.replace(",", " ").split("\n", 1)[1],
    "the sign of minus": COMMA.replace("-", "\N{MINUS SIGN}"),
    "exponents": COMMA.replace("0.45", "4.5e-1"),
}


@pytest.mark.parametrize("form", READ)
def test_the_same_samples(form: str) -> None:
    content = READ[form]
    found = inputs_from(content if isinstance(content, bytes) else content.encode(), "a.csv")
    assert_array_equal(found.times, TIMES)
    assert_array_equal(found.positions, PLACES)


REFUSED: dict[str, tuple[str | bytes, tuple[str, ...]]] = {
    "decimal commas between commas": (SEMICOLON.replace(";", ","), ("line 2", "8 values", "4", "semicolons")),
    "points and commas": (SEMICOLON.replace("-0,29", "-0.29"), ("line 3", "y = '-0.29'", "decimal sign")),
    "thousands": ("t;x;y;z\n1.764.275,5;0,1;0,1;0,1\n", ("line 2", "t = '1.764.275,5'", "thousands")),
    "thousands with commas": (
        't,x,y,z\n"1,764,275.5",0.1,0.1,0.1\n',
        ("line 2", "t = '1,764,275.5'", "thousands"),
    ),
    "a word": (SEMICOLON.replace("-0,29", "left"), ("line 3", "y = 'left' is not a number")),
    "an empty cell": (SEMICOLON.replace(";-0,29", ";"), ("line 3", "y = ''")),
    "a short row": (SEMICOLON.replace("0,1;0,45;", "0,1;"), ("line 4", "3 values", "4")),
    "milliseconds in the header": (
        COMMA.replace("t,x", "t [ms],x"),
        ("line 1", "t is in 'ms'", "seconds", "1000"),
    ),
    "millimetres in the header": (
        COMMA.replace(",z", ",z (mm)"),
        ("line 1", "z is in 'mm'", "metres", "1000"),
    ),
    "feet in the header": (COMMA.replace(",z", ",z/ft"), ("line 1", "z is in 'ft'", "metres")),
    "another order": (COMMA.replace("t,x,y,z", "x,y,z,t"), ("line 1", "t,x,y,z", "'x,y,z,t'")),
    "without a header": (COMMA.split("\n", 1)[1], ("line 1", "header", "t,x,y,z")),
    "Latin-1 among the values": (
        COMMA.replace("-0.29", "é").encode("latin-1"),
        ("not a text file", "line 3"),
    ),
    "half a character": (("\ufeff" + COMMA).encode("utf-16-le")[:-1], ("not a text file",)),
    "a picture": (b"\x89PNG\r\n\x1a\n\x00\xff" * 9, ("not a text file", "line 1")),
    "millimetres": ("t,x,y,z\n0,0,0,0\n1,450,-300,600\n", ("line 3", "x = 450 m", "millimetres", "1000")),
    "centimetres": ("t,x,y,z\n0,45,-30,60\n", ("line 2", "x = 45 m", "centimetres", "100")),
    "micrometres": ("t,x,y,z\n0,0,0,600000\n", ("line 2", "z = 600000 m", "micrometres")),
}


@pytest.mark.parametrize("form", REFUSED)
def test_unreadable_tables_are_refused_with_line_and_column(form: str) -> None:
    content, words = REFUSED[form]
    with pytest.raises(BadInputFile) as caught:
        inputs_from(content if isinstance(content, bytes) else content.encode(), "a.csv")
    message = str(caught.value)
    assert message.startswith("a.csv") and "\n" not in message and len(message) < 300
    assert [word for word in words if word not in message] == [], message


SEPARATORS = (",", ";", "\t", "|", " ", "   ", " ;", ", ", ";  ")
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32")


@given(st.data())
def test_any_dialect_of_the_same_numbers_gives_the_same_inputs(data: st.DataObject) -> None:
    pose = data.draw(st.booleans())
    numbers = st.floats(-9.9, 9.9).map(lambda number: round(number, 6))
    count = data.draw(st.integers(1, 6))
    times = np.cumsum(data.draw(st.lists(st.floats(0.001, 5.0), min_size=count, max_size=count))).tolist()
    quaternion = [st.floats(0.1, 1.0)] * 4 if pose else []
    rows = [[t, *data.draw(st.tuples(*[numbers] * 3, *quaternion))] for t in times]
    header = POSE_HEADER if pose else POSITION_HEADER
    plain = "\n".join([",".join(header), *(",".join(map(repr, row)) for row in rows)])

    separator = data.draw(st.sampled_from(SEPARATORS))
    commas = "," not in separator and data.draw(st.booleans())
    quoted = data.draw(st.booleans()) and separator.strip() != ""
    end = data.draw(st.sampled_from(("\n", "\r\n", "\r")))
    tail = separator.strip() * data.draw(st.integers(0, 2))
    names = [name.upper() if data.draw(st.booleans()) else name for name in header]
    if data.draw(st.booleans()):
        names = [
            name + {"t": " [s]", "x": " [m]", "y": "(m)", "z": "/m"}.get(name.lower(), "") for name in names
        ]
    lines = [names, *([repr(v).replace(".", ",") if commas else repr(v) for v in row] for row in rows)]
    if quoted:
        lines = [[f'"{cell}"' for cell in line] for line in lines]
    written = [separator.join(line) + tail for line in lines]
    for _ in range(data.draw(st.integers(0, 3))):
        extra = data.draw(st.sampled_from(("", "# a comment, 1; 2", "   ", "% 3", separator.strip() * 3)))
        written.insert(data.draw(st.integers(0, len(written))), extra)
    if separator.strip() in (";", "|") and data.draw(st.booleans()):
        written.insert(0, f"sep={separator.strip()}")
    content = end.join(written) + end * data.draw(st.integers(0, 2))

    expected, found = (
        inputs_from(text, "a.csv")
        for text in (plain.encode(), content.encode(data.draw(st.sampled_from(ENCODINGS))))
    )
    assert_array_equal(found.times, expected.times)
    assert_array_equal(found.positions, expected.positions)
    for t in times:
        a, b = found.target(t).rotation, expected.target(t).rotation
        assert (a is None) == (b is None) == (not pose)
        assert a is None or (b is not None and np.array_equal(a, b))


def test_a_start_posture_in_any_dialect(tmp_path: Path) -> None:
    room = room_of(RunSettings())
    values = [round(value, 4) for value in room.start.tolist()]
    names = [column.format("q") for column in room.columns]
    order = random.Random(1).sample(range(len(names)), len(names))
    plain, german = list(map(repr, values)), [repr(value).replace(".", ",") for value in values]
    forms = {
        "line": ",".join(plain), "blanks": " ".join(plain), "semicolons": ";".join(german) + ";", "tabs": "\t".join(german),
        "blanks and commas": " ".join(german), "column": "\n".join(plain), "column with commas": "\r\n".join(german),
        "header": ";".join(names[i] for i in order) + "\n" + ";".join(german[i] for i in order),
        "UTF-16": "\ufeff" + "\t".join(names) + "\r\n" + "\t".join(german) + "\r\n",
    }  # fmt: skip
    path = tmp_path / "start.csv"
    for form, text in forms.items():
        path.write_bytes(text.encode("utf-16-le" if form == "UTF-16" else "utf-8"))
        assert_array_equal(read_start(path, room), values, form)
