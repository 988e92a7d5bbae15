"""A custom law, as `lwr-duet run` uses it instead of the settings' law."""

from typing import Protocol, Self

from controllers.laws.situation import Law


class HeadlessProblem(Protocol):
    @property
    def text(self) -> str: ...


class HeadlessLaw(Law, Protocol):
    """A custom law, open while it runs.

    Attributes:
        file: name of the file.
        sha256: of the file, in hexadecimal digits.
    """

    file: str
    sha256: str

    @property
    def problem(self) -> HeadlessProblem | None:
        """Reason why the law is not in force; None while it is."""
        ...

    def __enter__(self) -> Self: ...

    def __exit__(self, *raised: object) -> None: ...
