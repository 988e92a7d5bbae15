"""Messages about a custom law in other languages, including messages from its process."""

import pytest
from msgspec import msgpack

from app.features.custom_law.law_file import LawFile, Wrong
from app.features.custom_law.law_limits import problem_of
from app.features.custom_law.trials import verdict_on
from app.features.custom_law.wire import Failure, TextParts, decode_reply, encode
from app.i18n.catalogue import words_of
from app.settings import LANGUAGES
from controllers.errors import LazyText
from controllers.laws.unprotected import Unprotected
from tests.app.i18n.messages import on_the_page
from tests.approved import Approve


def test_errors_of_a_law_are_sent_in_parts(approve: Approve) -> None:
    with pytest.raises(Wrong) as caught:
        LawFile("/my_law.py", b"law = 3", 2**20)
    assert TextParts.of(LazyText("a {b} \ud800")).text() == "a {b} ?"
    reply = decode_reply(encode(Failure(TextParts.of(caught.value.text), 3)))
    assert isinstance(reply, Failure)
    problem = problem_of("my_law.py", reply.text.text(), reply.line).text
    for language in LANGUAGES:
        approve(f"problem {language}.txt", f"{words_of(language)(problem)}\n")


@pytest.mark.parametrize(
    "sent",
    [
        b"not msgpack",
        *map(msgpack.encode, (3, ["Failure", ["a"], 1], ["Failure", ["a", 3], 1])),
        *(
            msgpack.encode(["Failure", [text, {"a": ["b", None]}], 1])
            for text in ("{a", "{a.b}", "{a:99999999}")
        ),
        b"\x93\xa7Failure" + b"\x92\xa0\x81\xa0" * 99999,
    ],
)
def test_a_law_that_writes_to_the_line_cannot_forge_parts(sent: bytes) -> None:
    with pytest.raises(ValueError):
        reply = decode_reply(sent)
        assert isinstance(reply, Failure)
        reply.text.text()


class Still(Unprotected):
    problem = None
    seconds = 0.0


def test_the_verdict_on_a_law_that_does_not_move(approve: Approve) -> None:
    verdict = verdict_on(Still(), "bounded where J_d is singular")
    for language in LANGUAGES:
        approve(f"verdict {language}.txt", f"{words_of(language)(verdict.reason)}\n")


def test_errors_of_a_law_file_are_texts_of_the_page() -> None:
    assert "law_file.py" in {path.name for path in on_the_page()}
