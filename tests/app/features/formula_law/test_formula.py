"""The language of formulas: what it computes, what it refuses, and that nothing in it reaches Python."""

import math
import re

import numpy as np
import pytest

from app.features.formula_law.formula import DEEPEST, MOST_CHARACTERS, MOST_TOKENS, BadFormula, Formula
from app.features.formula_law.formula_law import FormulaLaw
from app.features.formula_law.operations import ARRAYS, FUNCTIONS, NAMES, SCALARS
from scenes.settings import LawSettings

VALUES = (0.2, 0.1, 0.05, 0.3, 0.15, 6.0)
D, U, W, V, D_M, N = VALUES

COMPUTED = {
    "d + u - w": D + U - W,
    "d - u - w": D - U - W,
    "v / d / 2": V / D / 2,
    "-d^2": -(D**2),
    "2^3^2": 512.0,
    "2**-1": 0.5,
    "--d": D,
    "2 * (v + u) # a comment": 2 * (V + U),
    "where(d <= d_m, 1, (d_m / d)^n) * (v + u)": (D_M / D) ** N * (V + U),
    "if(d >= d_m, 1, 1 / 0)": 1.0,
    "min(d, u, w) + max(d, u, w)": W + D,
    "clip(5, u, v) + clip(-5, u, v)": V + U,
    "abs(-d) + exp(u) + log(n) + sqrt(d) + tanh(w)": D
    + math.exp(U)
    + math.log(N)
    + math.sqrt(D)
    + math.tanh(W),
    "d·u × 2 − w": D * U * 2 - W,
    "where(d ≤ 1, .5e1, 2.)": 5.0,
}


@pytest.mark.parametrize("text", COMPUTED)
def test_a_formula_is_arithmetic_of_floats_and_of_arrays(text: str) -> None:
    formula = Formula(text)
    assert formula.value(VALUES) == pytest.approx(COMPUTED[text], rel=1e-12)
    with np.errstate(all="ignore"):
        found = formula.values((np.full(3, D), *VALUES[1:]))
    np.testing.assert_allclose(np.broadcast_to(found, 3), COMPUTED[text], rtol=1e-12)


REFUSED = {
    "": (1, "is empty"),
    "d.real": (2, ". is not part"),
    "().__class__": (3, ". is not part"),
    "() + d": (2, "number or a name, and found )"),
    "__import__": (1, "__import__ is not known"),
    "eval(d)": (1, "eval is not known"),
    "d[0]": (2, "[ is not part"),
    "'d'": (1, "' is not part"),
    "d; u": (2, "; is not part"),
    "lambda: d": (7, ": is not part"),
    "d = u": (3, "= is not part"),
    "х + 1": (1, "U+0445 is not part"),
    "ｄ": (1, "U+FF44 is not part"),
    "d + ²": (5, "U+00B2 is not part"),
    "٣": (1, "U+0663 is not part"),
    "d\u200b": (2, "U+200B is not part"),
    "d\0": (2, "U+0000 is not part"),
    "\ud800": (1, "U+D800 is not part"),
    "1e999": (1, "too large"),
    "d u": (3, "found u"),
    "0,3": (2, "found ,"),
    "(d": (3, "expected ), and the formula ends"),
    "d +": (4, "formula ends"),
    "d < 1": (3, "belongs into where"),
    "where(d, 1, 2)": (8, "needs a comparison"),
    "where(d < 1, 2)": (1, "takes 3 values, not 2"),
    "min(d)": (1, "takes 2-8 values, not 1"),
    "sqrt d": (6, "expected (, and found d"),
    "(" * 10_000: (0, "10000 characters"),
    "9" * (MOST_CHARACTERS + 1): (0, "at most 1000"),
    "(" * MOST_TOKENS: (DEEPEST + 1, "inside one another"),
    "-" * MOST_TOKENS: (DEEPEST + 1, "inside one another"),
    "2^" * (MOST_TOKENS // 2) + "2": (MOST_TOKENS + 1, "more than 300"),
    "2^" * 60 + "2": (2 * DEEPEST + 1, "inside one another"),
    "min(" * 60 + "d": (4 * DEEPEST + 1, "inside one another"),
}


@pytest.mark.parametrize("text", REFUSED, ids=lambda text: repr(text[:12]))
def test_what_is_no_formula_is_refused_where_it_ends_to_be_one(text: str) -> None:
    column, said = REFUSED[text]
    with pytest.raises(BadFormula, match=re.escape(said)) as found:
        Formula(text)
    assert not column or str(found.value).startswith(f"Line 1, column {column}: ")


def test_an_error_names_the_line_and_what_is_valid() -> None:
    with pytest.raises(BadFormula, match=re.escape("Line 2, column 3: foo is not known.")) as found:
        Formula("d\n+ foo")
    assert all(name in str(found.value) for name in (*NAMES, "where", *FUNCTIONS))
    assert set(SCALARS.functions) == set(ARRAYS.functions) == set(FUNCTIONS) and set(SCALARS.signs) == set(
        ARRAYS.signs
    )


HUGE = (
    "10^10^10",
    "9^9^9^9^9^9",
    "exp(exp(exp(n)))",
    "1/0",
    "0/0",
    "0^-1",
    "(-8)^0.5",
    "sqrt(0-1)",
    "log(0)",
    "1e308*10",
    "d-d/0",
)


@pytest.mark.parametrize("text", HUGE)
def test_what_is_not_defined_stops_the_law_and_gives_no_curve(text: str) -> None:
    law = FormulaLaw(Formula(text), LawSettings)
    with pytest.raises((ArithmeticError, ValueError)):
        law.change(D, U, W)
    assert law.activation(D) == 0.0
    assert (
        np.isnan(law.line_rates(np.array([0.1, 0.2]), U, W, 1.0)).all()
        and np.isnan(law.activations(np.array([0.1]))).all()
    )


def test_the_longest_formula_is_computed_with_a_shallow_stack() -> None:
    text = "+".join(["d"] * (MOST_TOKENS // 2))
    assert Formula(text).value(VALUES) == pytest.approx(D * (MOST_TOKENS // 2))
    nested = "(" * (DEEPEST - 1) + "d" + ")" * (DEEPEST - 1)
    assert Formula(nested).value(VALUES) == D
