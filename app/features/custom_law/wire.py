"""Messages between page and law: msgpack over a `multiprocessing.connection.Connection`, without pickle.

Arrays are float64 bytes, to be quick.
"""

import string
from typing import Any, Final

import numpy as np
from msgspec import MsgspecError, Struct
from msgspec.msgpack import Decoder, Encoder

from app.features.custom_law.law_file import Array
from controllers.errors import LazyText
from controllers.laws.situation import Situation

BROKEN: Final = 76
"""Exit code after a broken connection (EX_PROTOCOL)."""

_MATRICES: Final = (Situation._fields.index("task_jacobian"), Situation._fields.index("rows"))


class LoadFile(Struct, tag=True, array_like=True, frozen=True):
    """Load this file."""

    text: bytes


class VelocityQuestion(Struct, tag=True, array_like=True, frozen=True, cache_hash=True):
    """Asks for q̇.

    Attributes:
        fields: of a `Situation`. Arrays are received as bytearrays, which the law may modify.
    """

    fields: tuple[bytearray | float | None, ...]

    @staticmethod
    def of(situation: tuple[Any, ...]) -> "VelocityQuestion":
        values: list[Any] = [
            value.tobytes() if isinstance(value, np.ndarray) else value for value in situation
        ]
        return VelocityQuestion(tuple(values))

    def situation(self) -> Situation:
        values: list[Any] = [
            np.frombuffer(value) if isinstance(value, bytearray) else value for value in self.fields
        ]
        for matrix in _MATRICES:
            if values[matrix] is not None:
                values[matrix] = values[matrix].reshape(-1, len(values[2]))
        return Situation(*values)


class ActivationQuestion(Struct, tag=True, array_like=True, frozen=True):
    """Asks for λ at a distance [m]."""

    distance: float


class ActivationsQuestion(Struct, tag=True, array_like=True, frozen=True):
    """Asks for λ at distances (k,) [m]."""

    distances: bytes


class RatesQuestion(Struct, tag=True, array_like=True, frozen=True):
    """Asks for J_d q̇ at distances (k,) [m]; see `Law.line_rate`."""

    distances: bytes
    pull: float
    approach: float
    square: float


LawQuestion = VelocityQuestion | ActivationQuestion | ActivationsQuestion | RatesQuestion


class TextParts(Struct, array_like=True):
    """Template and parts of a `LazyText`; parts are None for any other text."""

    template: str
    parts: dict[str, "TextParts"] | None

    @staticmethod
    def of(text: object) -> "TextParts":
        """Without lone surrogates, which cannot be sent."""
        lazy = isinstance(text, LazyText)
        template = (text.template if lazy else str(text)).encode(errors="replace").decode()
        return TextParts(
            template, {name: TextParts.of(part) for name, part in text.parts.items()} if lazy else None
        )

    def text(self) -> str:
        """The whole text.

        Raises:
            ValueError: invalid template; a law may write to the connection itself.
        """
        parts = self.parts
        if parts is None:
            return self.template
        fields = string.Formatter().parse(self.template) if parts else ()
        if not all(f is None or (f in parts and not form and not how) for _, f, form, how in fields):
            raise ValueError("not a template")
        return LazyText(self.template, **{name: part.text() for name, part in parts.items()})


class Started(Struct, tag=True, array_like=True):
    """The process runs."""


class FileLoaded(Struct, tag=True, array_like=True):
    """See `LawFile`."""

    wants_all_pairs: bool
    has_activation: bool


class Numbers(Struct, tag=True, array_like=True):
    """An answer, and the law's time [s]; None if it is not measured."""

    values: bytes
    seconds: float | None = None

    def array(self) -> Array:
        return np.frombuffer(self.values).copy()


class Failure(Struct, tag=True, array_like=True):
    text: TextParts
    line: int | None


Reply = Started | FileLoaded | Numbers | Failure

encode: Final = Encoder(enc_hook=float).encode
decode_question: Final = Decoder(LoadFile | LawQuestion).decode
_decode_reply: Final = Decoder(Reply).decode


def decode_reply(body: bytes) -> Reply:
    """Decode a reply.

    Raises:
        ValueError: not a reply; a law may write to the connection itself.
    """
    try:
        return _decode_reply(body)
    except (MsgspecError, RecursionError) as error:
        raise ValueError("not a reply") from error
