"""Actions that run a test's code between two frames, in the session's thread."""

from collections.abc import Callable

from app.session.actions import Action
from app.session.session import Session


class PostedCall(Action, newest_by=None):
    call: Callable[[], object]


class NamedCall(Action, newest_by=("name",)):
    name: str
    call: Callable[[], object]


def do_call(action: Action) -> None:
    assert isinstance(action, PostedCall | NamedCall)
    action.call()


def post_call(session: Session, call: Callable[[], object]) -> None:
    if not session.handlers.of(PostedCall):
        session.handlers.add(PostedCall, do_call)
    session.post(PostedCall(call))
