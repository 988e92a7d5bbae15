"""Custom laws of `lwr-duet run`."""

from typing import Protocol, Self

from controllers.laws.situation import Law


class HeadlessProblem(Protocol):
    @property
    def text(self) -> str: ...


class HeadlessLaw(Law, Protocol):
    """A custom law, open while it runs.

    Attributes:
        sha256: of its file, hexadecimal.
    """

    file: str
    sha256: str

    @property
    def problem(self) -> HeadlessProblem | None:
        """Reason why the law is not in force; None while it is."""
        ...

    def __enter__(self) -> Self: ...

    def __exit__(self, *raised: object) -> None: ...
