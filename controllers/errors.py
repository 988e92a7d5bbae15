"""Errors that the user can correct."""

from __future__ import annotations

from collections.abc import Iterable


class LazyText(str):
    """An English text that keeps its template and parts, to be shown in another language.

    It stays a `LazyText` when it is passed on or sent to another process; `+` or an f-string gives a plain
    text.

    Args:
        parts: values; a `LazyText` among them is translated, too.
    """

    template: str
    parts: dict[str, object]

    def __new__(cls, template: str, /, **parts: object) -> LazyText:
        """Fill in the parts; a template without parts is literal, braces included."""
        if isinstance(template, LazyText) and not parts:
            template, parts = template.template, template.parts
        made = super().__new__(cls, template.format(**parts) if parts else template)
        made.template, made.parts = template, parts
        return made

    def __getnewargs_ex__(self) -> tuple[tuple[str], dict[str, object]]:
        return (self.template,), self.parts

    def __str__(self) -> str:
        return self

    def __format__(self, spec: str) -> str:
        """A plain text; otherwise an f-string of nothing else would be this object."""
        return format(super().__str__(), spec)


class NumberText(str):
    """A number with its unit, shown with the language's decimal sign."""

    __slots__ = ()


def joined(parts: Iterable[str], between: str) -> LazyText:
    given = {f"_{i}": part for i, part in enumerate(parts)}
    return LazyText(between.join(f"{{{name}}}" for name in given), **given)


def first_line(error: BaseException) -> str:
    """First line of another program's error, shortened; its type if it has no text."""
    return (str(error).strip().splitlines() or [type(error).__name__])[0].rstrip(".")[:200]


class DuetError(Exception):
    """An error that the user can correct, shown as one line: the problem, then the valid choices or the
    remedy.

    Args:
        message: the line or, with parts, its template; see `LazyText`.
    """

    def __init__(self, message: str = "", /, **parts: object) -> None:
        super().__init__(LazyText(message, **parts) if parts or type(message) is str else message)

    def __str__(self) -> str:
        return str(self.args[0])

    def __format__(self, spec: str) -> str:
        return format(str(self), spec)


class BadSetting(DuetError):
    """A setting out of range or unknown; the message names it and the valid values."""


class BadInputFile(DuetError):
    """An unusable file (missing, unreadable, wrong kind, inconsistent); the message names it and the reason."""
