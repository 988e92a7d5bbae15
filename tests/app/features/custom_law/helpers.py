"""Law files, a situation to call them with, and functions that wait for a process."""

import textwrap
from contextlib import closing
from functools import reduce
from pathlib import Path

import numpy as np
from numpy.testing import assert_array_equal

from app.features.custom_law.command_options import CustomLawOptions
from app.features.custom_law.custom_law import CustomLaw
from app.features.custom_law.law_limits import LawLimits, LawTimeShare
from app.features.custom_law.student_law import StudentLaw
from app.features.custom_law.wire import VelocityQuestion, decode_question, encode
from app.runtime.job_pool import JobPool
from app.session.late_law import LateLawMaker
from app.session.session import Session
from app.settings import Settings
from controllers.kinematics import Array
from controllers.laws.situation import Situation, Unanswered
from scenes.settings import changed
from tests.app.runtime.processes import gone

SHORT = LawLimits(load=0.1, call=0.02, memory=96 * 2**20)
"""Short limits: an endless call is ended soon."""

PAPER = """
    D_M, ORDER, V, MU = 0.15, 6.0, 0.30, 0.06

    def activation(distance):
        return 1.0 if distance <= D_M else (D_M / distance) ** ORDER

    def law(situation):
        c = activation(situation.distance) * (V + situation.pull)
        J_d = situation.row
        return situation.nominal + J_d * c / (J_d @ J_d + MU**2)
"""


def write(path: Path, text: str) -> Path:
    path.write_text(textwrap.dedent(text).lstrip("\n"), encoding="utf-8")
    return path


def situation(n: int = 7, pairs: int = 5) -> Situation:
    """A situation 100 mm from an obstacle, with all fields set."""
    rng = np.random.default_rng(n)
    rows = rng.uniform(-0.5, 0.5, (pairs, n))
    bound = np.full(n, 2.0)
    return Situation(
        *(
            rng.uniform(-1.0, 1.0, n),
            rng.uniform(-0.5, 0.5, n),
            rows[0],
            0.1,
            0.2,
            rng.uniform(-1.0, 1.0, (3, n)),
        ),
        *(-bound, bound, rows, np.linspace(0.1, 0.5, pairs), rng.uniform(-0.1, 0.1, pairs)),
    )


def received(sent: Situation) -> Situation:
    question = decode_question(encode(VelocityQuestion.of(sent)))
    assert isinstance(question, VelocityQuestion)
    return question.situation()


def law_of(path: Path) -> LateLawMaker:
    """The law maker that a server with a law file uses for each session."""
    return lambda background, wake: StudentLaw(path, LawTimeShare(), background, wake)


def edited(path: Path) -> CustomLawOptions:
    """Options of a server with an editor for a file on its page."""
    return CustomLawOptions(edit_law=True, unnamed=path)


def session_of(path: Path, background: JobPool | None = None, **settings: object) -> closing[Session]:
    """A session of a server that has a law file; closed after a `with`."""
    given = reduce(lambda present, change: changed(present, *change), settings.items(), Settings())
    return closing(Session(given, background=background, law=law_of(path)))


ZEROS = np.zeros(7)
SITUATION = situation()
GOOD = "def law(s):\n    return s.nominal * 2"


def soon(law: CustomLaw) -> Array:
    """q̇ of a law that answers late, waited for up to a moment; zeros without an answer."""
    law.allow(1.0)
    try:
        law.activation(0.1)
        velocities = law(SITUATION)
    except Unanswered:
        return ZEROS
    law.step_made()
    return velocities


def frozen(law: CustomLaw) -> str:
    """Message of a law that fails when called. Its process must end at once without a restart."""
    with law:
        assert law.load() or law.problem
        pid = law.pid
        assert_array_equal(law(SITUATION), ZEROS)
        assert law.problem is not None and law.pid is None and not law.ready
        assert pid is None or gone(pid)
        assert_array_equal(law(SITUATION), ZEROS)
        assert law.activation(0.1) == 0.0 and np.isnan(law.line_rate(0.1, 0.1, 0.0, 1.0))
        assert law.pid is None
        assert law.problem.line is None or f"my_law.py, line {law.problem.line}: " in law.problem.text
        return law.problem.text
