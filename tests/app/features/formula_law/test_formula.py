"""The language of formulas: results, refusals, and no access to Python."""

import math

import numpy as np
import pytest

from app.features.formula_law.formula import DEEPEST, MOST_CHARACTERS, MOST_TOKENS, BadFormula, Formula
from app.features.formula_law.formula_law import FormulaLaw
from app.features.formula_law.operations import ARRAYS, FUNCTIONS, NAMES, SCALARS
from app.settings import LANGUAGES, Language
from scenes.settings import LawSettings
from tests.app.features.said import lines_of
from tests.approved import Approve

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
def test_a_formula_computes_with_floats_and_arrays(text: str) -> None:
    formula = Formula(text)
    assert formula.value(VALUES) == pytest.approx(COMPUTED[text], rel=1e-12)
    with np.errstate(all="ignore"):
        found = formula.values((np.full(3, D), *VALUES[1:]))
    np.testing.assert_allclose(np.broadcast_to(found, 3), COMPUTED[text], rtol=1e-12)


REFUSED = {
    "empty": "",
    "attribute": "d.real",
    "attribute of nothing": "().__class__",
    "nothing in brackets": "() + d",
    "double underscores": "__import__",
    "eval": "eval(d)",
    "index": "d[0]",
    "quotes": "'d'",
    "statements": "d; u",
    "lambda": "lambda: d",
    "assignment": "d = u",
    "Cyrillic": "х + 1",
    "full width": "ｄ",
    "superscript": "d + ²",
    "Arabic digit": "٣",
    "no width": "d\u200b",
    "null": "d\0",
    "surrogate": "\ud800",
    "too large": "1e999",
    "two names": "d u",
    "decimal comma": "0,3",
    "open bracket": "(d",
    "no right side": "d +",
    "comparison alone": "d < 1",
    "where without comparison": "where(d, 1, 2)",
    "where of two": "where(d < 1, 2)",
    "min of one": "min(d)",
    "no bracket": "sqrt d",
    "another name, line 2": "d\n+ foo",
    "10000 brackets": "(" * 10_000,
    "long number": "9" * (MOST_CHARACTERS + 1),
    "nested brackets": "(" * MOST_TOKENS,
    "signs": "-" * MOST_TOKENS,
    "many powers": "2^" * (MOST_TOKENS // 2) + "2",
    "nested powers": "2^" * 60 + "2",
    "nested functions": "min(" * 60 + "d",
}


@pytest.mark.parametrize("language", LANGUAGES)
def test_an_invalid_formula_is_refused_at_the_first_wrong_place(language: Language, approve: Approve) -> None:
    said = dict[str, str]()
    for case, text in REFUSED.items():
        with pytest.raises(BadFormula) as found:
            Formula(text)
        said[case] = str(found.value)
    approve(f"refused formulas {language}.txt", lines_of(said, language))


def test_an_error_names_what_is_valid() -> None:
    with pytest.raises(BadFormula) as found:
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
def test_an_undefined_value_stops_the_law_and_gives_no_curve(text: str) -> None:
    law = FormulaLaw(Formula(text), LawSettings)
    with pytest.raises((ArithmeticError, ValueError)):
        law.change(D, U, W)
    assert law.activation(D) == 0.0
    assert (
        np.isnan(law.line_rates(np.array([0.1, 0.2]), U, W, 1.0)).all()
        and np.isnan(law.activations(np.array([0.1]))).all()
    )


def test_the_longest_formula_needs_a_shallow_stack() -> None:
    text = "+".join(["d"] * (MOST_TOKENS // 2))
    assert Formula(text).value(VALUES) == pytest.approx(D * (MOST_TOKENS // 2))
    nested = "(" * (DEEPEST - 1) + "d" + ")" * (DEEPEST - 1)
    assert Formula(nested).value(VALUES) == D
