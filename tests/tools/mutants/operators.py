"""Small mistakes in a source text, one at a time: each replaces one piece of the text.

Docstrings, type hints, texts, assertions, log messages and texts of exceptions are not changed.
"""

import ast
import copy
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

FLIPPED: Final[dict[type[ast.cmpop], type[ast.cmpop]]] = {
    ast.Lt: ast.Gt,
    ast.Gt: ast.Lt,
    ast.LtE: ast.GtE,
    ast.GtE: ast.LtE,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
ARITHMETIC: Final[dict[type[ast.operator], type[ast.operator]]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
}
EXTREMES: Final = {"min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum"} | {
    "argmin": "argmax",
    "argmax": "argmin",
}
COMMUTATIVE: Final = frozenset({"min", "max", "minimum", "maximum", "hypot", "array_equal"})
CONDITIONAL: Final = (ast.If, ast.While, ast.IfExp)
LOGS: Final = frozenset({"_log", "log", "logger", "_logger", "logging", "warnings"})


@dataclass(frozen=True)
class Change:
    """One mistake in a source text.

    Attributes:
        operator: kind of mistake.
        line: first line of the piece (1-based).
        begin, end: place of the piece in the UTF-8 text [bytes].
        before, after: the piece.
    """

    operator: str
    line: int
    begin: int
    end: int
    before: str
    after: str


def changes(source: str) -> list[Change]:
    """All possible mistakes in a source text, in its order.

    Raises:
        SyntaxError: the text is not Python.
    """
    whole = source.encode()
    starts = [0]
    for line in whole.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    found: list[Change] = []
    for node, inside in _nodes(ast.parse(source), inside=False):
        for operator, new in _mistakes(node, inside):
            # Only the condition is replaced, so that its block keeps its indentation.
            piece = node.test if operator == "condition" and isinstance(node, CONDITIONAL) else node
            assert piece.end_lineno is not None and piece.end_col_offset is not None
            begin = starts[piece.lineno - 1] + piece.col_offset
            end = starts[piece.end_lineno - 1] + piece.end_col_offset
            bare = not isinstance(new, ast.expr) or isinstance(new, ast.Slice)
            after = ast.unparse(new) if bare else f"({ast.unparse(new)})"
            found.append(Change(operator, piece.lineno, begin, end, whole[begin:end].decode(), after))
    return found


def changed(source: str, change: Change) -> str | None:
    """The source text with a mistake; None if it is equivalent or not valid."""
    whole = source.encode()
    text = (whole[: change.begin] + change.after.encode() + whole[change.end :]).decode()
    try:
        return text if ast.dump(ast.parse(text)) != ast.dump(ast.parse(source)) else None
    except SyntaxError:
        return None


Placed = ast.expr | ast.stmt


def _nodes(node: ast.AST, inside: bool) -> Iterator[tuple[Placed, bool]]:
    """Expressions and statements for mistakes, each with True inside a function."""
    if isinstance(node, ast.JoinedStr | ast.Assert | ast.Raise | ast.Import | ast.ImportFrom):
        return
    if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING"):
        return
    if isinstance(node, ast.Expr) and (isinstance(node.value, ast.Constant) or _logs(node.value)):
        return
    if isinstance(node, ast.expr | ast.stmt):
        yield node, inside
    inside = inside or isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "type_params"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield from _nodes(child, inside)


def _logs(node: ast.expr) -> bool:
    if not isinstance(node, ast.Call):
        return False
    whose = node.func.value if isinstance(node.func, ast.Attribute) else node.func
    return isinstance(whose, ast.Name) and whose.id in LOGS | {"print"}


def _mistakes(node: Placed, inside: bool) -> Iterator[tuple[str, Placed]]:
    """Kind and new form of each mistake at a node."""
    new = copy.copy(node)
    match node, new:
        case ast.Compare(), ast.Compare():
            new.ops = [FLIPPED[type(node.ops[0])](), *node.ops[1:]]
            yield "comparison", new
        case (ast.BinOp(), ast.BinOp()) | (ast.AugAssign(), ast.AugAssign()):
            if type(node.op) in ARITHMETIC and not _is_text(node):
                new.op = ARITHMETIC[type(node.op)]()
                yield "arithmetic", new
        case ast.Constant(), ast.Constant():
            if isinstance(node.value, bool):
                new.value = not node.value
                yield "constant", new
            elif isinstance(node.value, int | float):
                new.value = node.value + 1 if isinstance(node.value, int) else node.value * 1.5 or 1.0
                yield "constant", new
        case ast.BoolOp(), ast.BoolOp():
            new.op = ast.Or() if isinstance(node.op, ast.And) else ast.And()
            yield "and, or", new
        case ((ast.If() | ast.While() | ast.IfExp()), _):
            yield "condition", ast.UnaryOp(ast.Not(), node.test)
        case ast.Return(), ast.Return():
            if node.value is not None and not _is_none(node.value):
                new.value = ast.Constant(None)
                yield "return", new
        case ast.Slice(), ast.Slice():
            yield from _other_slices(node)
        case ast.Call(), ast.Call():
            yield from _other_calls(node)
        case _:
            pass
    if inside and _can_be_left_out(node):
        yield "deletion", ast.Pass()


def _is_text(node: ast.BinOp | ast.AugAssign) -> bool:
    sides = (node.left, node.right) if isinstance(node, ast.BinOp) else (node.value,)
    return any(
        isinstance(side, ast.JoinedStr) or (isinstance(side, ast.Constant) and isinstance(side.value, str))
        for side in sides
    )


def _is_none(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def _other_slices(node: ast.Slice) -> Iterator[tuple[str, ast.Slice]]:
    """Slices that begin one later, or end one earlier."""
    one = ast.Constant(1)
    if node.lower is not None:
        yield "slice", ast.Slice(ast.BinOp(node.lower, ast.Add(), one), node.upper, node.step)
    if node.upper is not None:
        yield "slice", ast.Slice(node.lower, ast.BinOp(node.upper, ast.Sub(), one), node.step)


def _other_calls(node: ast.Call) -> Iterator[tuple[str, ast.Call]]:
    """A minimum becomes a maximum; the first two arguments are swapped."""
    name = ""
    if isinstance(node.func, ast.Name):
        name = node.func.id
        other: ast.expr = ast.Name(EXTREMES.get(name, name))
    elif isinstance(node.func, ast.Attribute):
        name = node.func.attr
        other = ast.Attribute(node.func.value, EXTREMES.get(name, name))
    else:
        return
    if name in EXTREMES:
        yield "minimum, maximum", ast.Call(other, node.args, node.keywords)
    plain = len(node.args) >= 2 and not any(isinstance(one, ast.Starred) for one in node.args[:2])
    if plain and name not in COMMUTATIVE:
        first, second, *rest = node.args
        yield "argument order", ast.Call(node.func, [second, first, *rest], node.keywords)


def _can_be_left_out(node: Placed) -> bool:
    """True if the function is still valid without the statement: it assigns no local name."""
    if isinstance(node, ast.Assign):
        return all(isinstance(target, ast.Attribute | ast.Subscript) for target in node.targets)
    return isinstance(node, ast.Expr | ast.AugAssign | ast.Continue | ast.Break)
