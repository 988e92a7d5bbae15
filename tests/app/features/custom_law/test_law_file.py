"""A custom law's file, read and called without a process: errors are described plainly, with the line."""

import subprocess
import sys
import textwrap

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from app.features.custom_law.law_file import LawFile, Wrong
from app.settings import LANGUAGES, Language
from tests.app.features.custom_law.helpers import PAPER, received, situation
from tests.app.features.said import lines_of
from tests.approved import Approve


def file_of(text: str) -> LawFile:
    return LawFile("/somewhere/my_law.py", textwrap.dedent(text).lstrip("\n").encode(), 512 << 20)


def wrong(text: str) -> Wrong:
    with pytest.raises(Wrong) as caught:
        file_of(text).velocities(received(situation()))
    return caught.value


def test_the_law_process_needs_no_robotics_library() -> None:
    """It imports the situation of all laws and still starts within 0.1 s."""
    code = "import sys, app.features.custom_law.worker; sys.exit(any(name in sys.modules for name in ('pinocchio', 'coal', 'scipy')))"
    assert subprocess.run([sys.executable, "-c", code], timeout=60).returncode == 0


@pytest.mark.parametrize(("n", "pairs"), [(6, 5), (7, 0), (14, 40)])
@pytest.mark.parametrize(
    "bare", ["", "task_jacobian", "lower upper", "rows distances approaches", "approaches"]
)
def test_a_situation_is_transferred_bit_for_bit(n: int, pairs: int, bare: str) -> None:
    sent = situation(n, max(pairs, 1))
    if pairs == 0:
        sent = sent._replace(rows=np.zeros((0, n)), distances=np.zeros(0), approaches=np.zeros(0))
    assert sent.task_jacobian is not None and sent.rows is not None
    sent = sent._replace(
        task_jacobian=np.asfortranarray(sent.task_jacobian), rows=np.repeat(sent.rows, 2, axis=1)[:, ::2]
    )
    sent = sent._replace(distance=float("inf"), **dict.fromkeys(bare.split(), None))  # pyright: ignore[reportArgumentType]
    got = received(sent)
    for name, there, here in zip(sent._fields, sent, got, strict=True):
        if there is None:
            assert here is None, name
        else:
            assert_array_equal(here, there, err_msg=name)
            assert not isinstance(here, np.ndarray) or (here.flags.writeable and here.flags.aligned)


OURS = {
    "exit": "def law(s):\n    import sys\n    sys.exit(3)",
    "exit at once": "raise SystemExit",
    "no return": "def law(s):\n    pass",
    "three of seven": "# A law.\ndef law(s):\n    return s.nominal[:3]",
    "a row": "def law(s):\n    return s.nominal[None, :]",
    "a number": "def law(s):\n    return 0.5",
    "a text": "def law(s):\n    return 'fast'",
    "texts": "def law(s):\n    return ['a'] * 7",
    "complex": "def law(s):\n    return s.nominal * 1j",
    "uneven": "def law(s):\n    return [[1.0], [1.0, 2.0]]",
    "a function": "def law(s):\n    return law",
    "nan": "def law(s):\n    s.nominal[2] = float('nan')\n    return s.nominal",
    "infinity": "def law(s):\n    return s.nominal * float('inf')",
    "another name": "def lwa(s):\n    return s.nominal",
    "a law that is 3": "law = 3",
    "nothing": "",
    "minus signs": "a = " + "-" * 100_000 + "1",
    "sums": "a = " + " + ".join("1" * 100_000),
}


@pytest.mark.parametrize("language", LANGUAGES)
def test_errors_in_our_words(language: Language, approve: Approve) -> None:
    errors = {case: wrong(text) for case, text in OURS.items()}
    said = {f"{case}, line {error.line}": error.text for case, error in errors.items()}
    approve(f"wrong files {language}.txt", lines_of(said, language))


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        ("def law(s):\n    x = 1\n    return x / 0", 3, "in “return x / 0”"),
        # The last line in the student's file, not the one in the library.
        ("import numpy as np\n\ndef inner(s):\n    return np.linalg.inv(np.zeros((2, 2)))\n\ndef law(s):\n    return inner(s)",
         4, "in “return np.linalg.inv"),
        ("def law(s):\n    return s.rwo", 2, "'rwo'"),
        ("def law(s):\n    raise ValueError(s.distance)", 2, "ValueError: 0.1"),
        ("def law(s):\n    raise KeyboardInterrupt", 2, "KeyboardInterrupt"),
        ("def law(s):\n    return law(s)", 2, "RecursionError"),
        ("x = 1\ndef law(s)\n    return s.nominal", 2, "in “def law(s)”"),
        ("def law(s):\nreturn s.nominal", 2, "IndentationError"),
        ("x = 1 / 0\ndef law(s):\n    return s.nominal", 1, "in “x = 1 / 0”"),
        ("import numpyy\ndef law(s):\n    return s.nominal", 1, "'numpyy'"),
        ("# A law.\ndef law():\n    return 0", 2, "law(situation)"),
        ("def law(s, gain):\n    return 0", 1, "'gain'"),
    ],
)  # fmt: skip
def test_errors_in_pythons_words_name_the_line(text: str, line: int | None, says: str) -> None:
    error = wrong(text)
    assert says in error.text, error.text
    assert error.line == line
    assert len(error.text) <= 300 and "\n" not in error.text


def test_messages_and_encodings() -> None:
    long = "def law(s):\n    raise ValueError('x' * 10_000)"
    assert len(wrong(long).text) == 300
    # All that Python reads: a declared encoding, a byte order mark, line ends of Windows.
    for text in (
        "# coding: latin-1\r\n# für\r\ndef law(s):\r\n    return s.nominal / 0 + ü".encode("latin-1"),
        "\ufeff# für\n\ndef law(s):\n    return s.nominal / 0 + ü".encode(),
    ):
        law = LawFile("my_law.py", text, 0)
        with (
            pytest.raises(Wrong, match="ü”") as caught,
            np.errstate(all="ignore"),
        ):
            law.velocities(situation())
        assert caught.value.line == 4
    # Python's messages for these differ between 3.11.2, 3.11.4 and 3.13.
    bytes_after_text, declared = b"def law(s):\n    return s.nominal\n\x00", (b"klingon", b"rot13", b"ascii")
    for no_text in (
        *(
            b"def law(s):\n    return '\xff'",
            b"\x00\x01",
            bytes_after_text,
            "def law(s): pass".encode("utf-16"),
        ),
        *(b"# coding: " + name + b"\ndef law(s):\n    return '\xc3\xbc'" for name in declared),
    ):
        with pytest.raises(Wrong, match="UTF-8"):
            LawFile("my_law.py", no_text, 0)


@pytest.mark.parametrize(
    "returned", ["[0.1] * 7", "(1,) * 7", "s.nominal.astype('f4')", "[True] * 7", "list(s.nominal)"]
)
def test_returned_values_similar_to_an_array_are_accepted(returned: str) -> None:
    velocities, seconds = file_of(f"def law(s):\n    return {returned}").velocities(situation())
    assert velocities.dtype == np.float64 and velocities.shape == (7,)
    assert seconds >= 0.0


def test_a_file_and_its_curves() -> None:
    # Defaults: all pairs, λ only if defined; code under __main__ is not run on the page.
    law = file_of("def law(s):\n    return s.nominal\nif __name__ == '__main__':\n    raise ValueError")
    assert law.wants_all_pairs and not law.has_activation
    law = file_of(f"WANTS_ALL_PAIRS = False\n{textwrap.dedent(PAPER)}")
    assert not law.wants_all_pairs and law.has_activation
    assert (
        law.activation(0.3) == 0.5**6 and law.activation(0.1) == 1.0 and law.activation(float("inf")) == 0.0
    )
    # J_d q̇ = λ v − (1 − λ) u of the paper's law at every distance; u, w and |J_d| as requested.
    law = file_of(PAPER.replace("0.30, 0.06", "0.30, 0.0"))
    d, u = np.array([0.1, 0.2, 0.4, np.inf]), 0.2
    lam = np.minimum(0.15 / d, 1.0) ** 6
    for square in (0.04, 1.0, 0.0):
        np.testing.assert_allclose(law.rates(d, u, 0.1, square), lam * 0.3 - (1.0 - lam) * u, atol=1e-12)
    seen = file_of("def law(s):\n    return s.nominal * 0 + [s.approach, s.pull, 0, 0, 0, 0, 0]").rates(
        d, u, 0.1, 0.25
    )
    np.testing.assert_allclose(seen, 0.5 * 0.1)
    near = file_of("def law(s):\n    return s.nominal / (s.distance > 0.2) if s.distance > 0.2 else None")
    found = near.rates(np.array([0.1, 0.3]), 0.1, 0.0, 1.0)
    assert np.isnan(found[0]) and found[1] == pytest.approx(-0.1)


@pytest.mark.parametrize(
    ("returned", "says"),
    [("1.5", "1.5 at d = 0.2 m; expected 0 to 1"), ("float('nan')", "nan"), ("None", "returned None"), ("'x'", "returned a str"),
     ("1 / 0", "Zero")],
)  # fmt: skip
def test_an_invalid_activation_is_refused(returned: str, says: str) -> None:
    law = file_of(f"def law(s):\n    return s.nominal\ndef activation(d):\n    return {returned}")
    with pytest.raises(Wrong, match=says) as caught:
        law.activation(0.2)
    assert caught.value.line == (4 if says == "Zero" else 3)
