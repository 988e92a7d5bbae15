"""Pages in other languages, without a browser."""

from collections.abc import Iterator

from tests.app.conftest import Arrive, Guest, OpenHouse, ask
from tests.app.i18n.conftest import untranslated
from tests.blocking_client import BlockingClient

TEXTS = ("label", "hint", "content", "options", "_tab_labels", "title", "body", "description")


def texts(visitor: BlockingClient) -> Iterator[str]:
    for element in [*list(visitor.mirror.gui.values()), *list(visitor.mirror.commands.values())]:
        for found in map(element.get, TEXTS):
            yield from (
                text for text in ([found] if isinstance(found, str) else found or ()) if isinstance(text, str)
            )


def assert_all_said(visitor: BlockingClient) -> None:
    left = {text[:120]: words for text in texts(visitor) if (words := untranslated(text))}
    assert left == {}


def choose(guest: Guest, **values: object) -> None:
    ask(guest.session, lambda s: [s.change(key, value) for key, value in values.items()])
    guest.run_on(0.2)


def comes(visitor: BlockingClient, word: str) -> None:
    visitor.wait_for(lambda _: any(word in text for text in texts(visitor)))


def test_the_pseudo_language_leaves_no_text_untranslated(house: OpenHouse, arrive: Arrive) -> None:
    guest = arrive(house(), "lang=pseudo&details=none&speed=2")
    assert_all_said(guest.visitor)
    choose(guest, ghost="frozen", whatif=True)
    for scene, plot, law in (
        *(
            ("solo", "joints", "smooth_priority"),
            ("ball", "curve", "null_space_avoidance"),
            ("hold", "laws", "barrier_qp"),
        ),
        *(("hold", "map", "strict_switched"), ("master_slave", "follow", "potential_field")),
        *(("hold", "speeds", "strict_priority"), ("imitation", "follow", "unprotected")),
        *(("imitation", "pairs", "intermediate_value"), ("hold", "stability", "smooth_priority")),
        ("hold", "stability", "barrier_qp"),
    ):
        choose(guest, scene=scene, plot=plot, law=law)
        assert_all_said(guest.visitor)
