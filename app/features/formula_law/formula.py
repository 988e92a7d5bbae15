"""Grammar and parser of a law's formula: one arithmetic expression, never read by Python.

    sum     = product { ("+" | "-") product }
    product = sign { ("*" | "/") sign }
    sign    = ("-" | "+") sign | power
    power   = atom [ ("^" | "**") sign ]
    atom    = number | name | function "(" argument { "," argument } ")" | "(" sum ")"

Only the first argument of `where` is a comparison, of two sums. All numbers are floats, so that no power
takes long; within the limits below a value costs some microseconds.
"""

import re
from typing import Final, NamedTuple

from app.features.formula_law.operations import (
    ARRAYS,
    COMPARISONS,
    FUNCTIONS,
    NAMES,
    SCALARS,
    Evaluated,
    Operations,
)
from app.i18n.speaking import N_
from controllers.errors import DuetError, LazyText

MOST_CHARACTERS: Final = 1000
"""Longest formula [characters]."""

MOST_TOKENS: Final = 300
"""Longest formula [tokens]."""

DEEPEST: Final = 40

_TOKEN: Final = re.compile(
    r"(?P<space>[ \t\r\n]+|\#[^\n]*)|(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"|(?P<name>[A-Za-z_][A-Za-z0-9_]*)|(?P<sign>\*\*|<=|>=|[-+*/^(),<>−·×≤≥])"
)

_SAME: Final = {"**": "^", "−": "-", "·": "*", "×": "*", "≤": "<=", "≥": ">="}
"""Printed signs and Python's power → sign of the grammar."""

_END: Final = ""


class BadFormula(DuetError):
    """The message names line and column."""


class Token(NamedTuple):
    """A number, a name or a sign.

    `kind`: "number", "name", "sign", or "" at the end; `place`: index of its first character.
    """

    kind: str
    text: str
    place: int


class Node(NamedTuple):
    """A part of a formula.

    Attributes:
        what: "number", "name", "where", a function, or a sign; with one part, a negation.
        value: the number, or the index in `NAMES`.
    """

    what: str
    value: float = 0.0
    parts: "tuple[Node, ...]" = ()


class Formula:
    """A formula as a function of the values of `NAMES`.

    Attributes:
        value: of floats; raises ArithmeticError or ValueError where it is not defined.
        values: of arrays and floats; not finite where it is not defined.

    Raises:
        BadFormula: not a formula.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        parsed = _Parser(text).parse()
        self.value: Evaluated = _function(parsed, SCALARS)
        self.values: Evaluated = _function(parsed, ARRAYS)


def _function(node: Node, operations: Operations) -> Evaluated:
    if node.what == "number":
        return lambda values, number=node.value: number
    if node.what == "name":
        return lambda values, index=int(node.value): values[index]
    parts = tuple(_function(part, operations) for part in node.parts)
    if node.what == "where":
        return operations.where(*parts)
    function = operations.of(node.what, len(parts))
    if len(parts) == 1:
        one = parts[0]
        return lambda values: function(one(values))
    if len(parts) == 2:
        left, right = parts
        return lambda values: function(left(values), right(values))
    return lambda values: function(*[part(values) for part in parts])


class _Parser:
    def __init__(self, text: str) -> None:
        self._text = text
        if len(text) > MOST_CHARACTERS:
            raise BadFormula(
                "The formula has {count} characters; at most {most} are read.",
                count=len(text),
                most=MOST_CHARACTERS,
            )
        self._tokens = self._read()
        self._next, self._depth = 0, 0

    def _read(self) -> list[Token]:
        found: list[Token] = []
        place = 0
        while place < len(self._text):
            match = _TOKEN.match(self._text, place)
            if match is None:
                raise self._unreadable(place)
            kind = match.lastgroup or ""
            if kind != "space":
                found.append(Token(kind, _SAME.get(match[0], match[0]), place))
            place = match.end()
        if len(found) > MOST_TOKENS:
            what = N_("the formula has more than {most} numbers, names and signs.")
            raise self._fault(found[MOST_TOKENS].place, what, most=MOST_TOKENS)
        return [*found, Token("", _END, len(self._text))]

    def _unreadable(self, place: int) -> BadFormula:
        sign = self._text[place]
        shown = sign if sign.isascii() and sign.isprintable() else f"U+{ord(sign):04X}"
        return self._fault(place, N_("{sign} is not part of a formula. {valid}"), sign=shown, valid=_valid())

    def _fault(self, place: int, what: str, **parts: object) -> BadFormula:
        before = self._text[:place]
        line, column = before.count("\n") + 1, place - before.rfind("\n")
        said = LazyText(what, **parts)
        return BadFormula("Line {line}, column {column}: {what}", line=line, column=column, what=said)

    def parse(self) -> Node:
        if self._token.kind == "":
            raise self._fault(0, N_("the formula is empty. {valid}"), valid=_valid())
        node = self._sum()
        token = self._token
        if token.text in COMPARISONS:
            raise self._fault(token.place, N_("a comparison belongs into where(comparison, then, else)."))
        if token.kind:
            raise self._fault(
                token.place, N_("expected a sign or the end, and found {found}."), found=token.text
            )
        return node

    @property
    def _token(self) -> Token:
        return self._tokens[self._next]

    def _take(self, *texts: str) -> Token | None:
        token = self._token
        if token.kind != "sign" or token.text not in texts:
            return None
        self._next += 1
        return token

    def _expect(self, text: str) -> None:
        if self._take(text) is None:
            token = self._token
            if token.kind:
                raise self._fault(
                    token.place, N_("expected {wanted}, and found {found}."), wanted=text, found=token.text
                )
            raise self._fault(token.place, N_("expected {wanted}, and the formula ends."), wanted=text)

    def _sum(self) -> Node:
        node = self._product()
        while (sign := self._take("+", "-")) is not None:
            node = Node(sign.text, parts=(node, self._product()))
        return node

    def _product(self) -> Node:
        node = self._sign()
        while (sign := self._take("*", "/")) is not None:
            node = Node(sign.text, parts=(node, self._sign()))
        return node

    def _sign(self) -> Node:
        self._depth += 1
        if self._depth > DEEPEST:
            raise self._fault(
                self._token.place,
                N_("more than {most} brackets, signs or powers inside one another."),
                most=DEEPEST,
            )
        sign = self._take("+", "-")
        node = self._power() if sign is None else self._sign()
        self._depth -= 1
        return Node("-", parts=(node,)) if sign is not None and sign.text == "-" else node

    def _power(self) -> Node:
        node = self._atom()
        return node if self._take("^") is None else Node("^", parts=(node, self._sign()))

    def _atom(self) -> Node:
        token = self._token
        if self._take("(") is not None:
            node = self._sum()
            self._expect(")")
            return node
        if token.kind == "number":
            self._next += 1
            number = float(token.text)
            if number == float("inf"):
                raise self._fault(token.place, N_("the number is too large."))
            return Node("number", number)
        if token.kind == "name":
            self._next += 1
            return self._name(token)
        if token.kind:
            raise self._fault(
                token.place, N_("expected a number or a name, and found {found}."), found=token.text
            )
        raise self._fault(token.place, N_("the formula ends where a number or a name is expected."))

    def _name(self, token: Token) -> Node:
        if token.text in NAMES:
            return Node("name", NAMES.index(token.text))
        name = "where" if token.text == "if" else token.text
        if name != "where" and name not in FUNCTIONS:
            raise self._fault(
                token.place, N_("{name} is not known. {valid}"), name=token.text[:40], valid=_valid()
            )
        self._expect("(")
        parts = [self._condition() if name == "where" else self._sum()]
        while self._take(",") is not None:
            parts.append(self._sum())
        self._expect(")")
        least, most = (3, 3) if name == "where" else FUNCTIONS[name]
        if not least <= len(parts) <= most:
            what = N_("{name} takes {wanted} values, not {count}.")
            wanted = str(least) if least == most else f"{least}-{most}"
            raise self._fault(token.place, what, name=token.text, wanted=wanted, count=len(parts))
        return Node(name, parts=tuple(parts))

    def _condition(self) -> Node:
        left = self._sum()
        sign = self._take(*COMPARISONS)
        if sign is None:
            raise self._fault(self._token.place, N_("where needs a comparison first, such as d < d_m."))
        return Node(sign.text, parts=(left, self._sum()))


def _valid() -> LazyText:
    return LazyText(
        "Names: {names}. Functions: {functions}.",
        names=", ".join(NAMES),
        functions=", ".join(("where", *FUNCTIONS)),
    )
