"""Pages in other languages, without a browser: what the server sends."""

from collections.abc import Iterator

from app.i18n.pseudo import pseudo
from app.lessons.loading import load_lessons
from app.settings import Settings
from app.text.lesson_text import plain
from scenes.settings import changed
from tests.app.conftest import Arrive, Guest, Join, OpenHouse, ask
from tests.app.i18n.conftest import untranslated
from tests.app.page.helpers import bodies, notes, open_lessons
from tests.blocking_client import BlockingClient

TEXTS = ("label", "hint", "content", "options", "_tab_labels", "title", "body", "description")


def texts(visitor: BlockingClient) -> Iterator[str]:
    for element in [*list(visitor.mirror.gui.values()), *list(visitor.mirror.commands.values())]:
        for found in map(element.get, TEXTS):
            yield from (text for text in ([found] if isinstance(found, str) else found or ()) if isinstance(text, str))


def comes(visitor: BlockingClient, word: str) -> None:
    visitor.wait_for(lambda _: any(word in text for text in texts(visitor)))


def labels(visitor: BlockingClient) -> list[str]:
    return [str(element["label"]) for element in list(visitor.mirror.gui.values()) if element.get("label")]


def assert_all_said(visitor: BlockingClient) -> None:
    left = {text[:120]: words for text in texts(visitor) if (words := untranslated(text))}
    assert left == {}


def choose(guest: Guest, **values: object) -> None:
    ask(guest.session, lambda s: [s.change(key, value) for key, value in values.items()])
    guest.run_on(0.5)


def test_in_pseudo_nothing_is_left_untranslated(house: OpenHouse, arrive: Arrive) -> None:
    guest = arrive(house(), "lang=pseudo&details=none")
    assert_all_said(guest.visitor)
    choose(guest, ghost="frozen", whatif=True)
    for scene, plot, law in (
        *(("solo", "joints", "smooth_priority"), ("ball", "curve", "null_space_avoidance"), ("hold", "laws", "barrier_qp")),
        *(
            ("hold", "map", "strict_switched"),
            ("master_slave", "follow", "potential_field"),
            ("hold", "speeds", "strict_priority"),
        ),
        *(("imitation", "follow", "unprotected"), ("imitation", "pairs", "intermediate_value")),
        *(("hold", "stability", "smooth_priority"), ("hold", "stability", "barrier_qp")),
    ):
        choose(guest, scene=scene, plot=plot, law=law)
        assert_all_said(guest.visitor)
    ask(guest.session, lambda s: s.measure_smoothness())
    choose(guest, scene="imitation", source="camera")
    assert_all_said(guest.visitor)


def test_controls_work_in_another_language(house: OpenHouse, arrive: Arrive) -> None:
    guest = arrive(house(), "lang=de")
    guest.visitor.set_value("Szene", "Ein Ball im Weg (Abb. 1)")
    guest.wait(lambda s: s.settings.run.scene == "ball")
    clock = guest.visitor.mirror.labelled("Uhr")
    guest.visitor.send({"type": "GuiUpdateMessage", "uuid": clock["uuid"], "updates": {"value": "Pause"}})
    guest.wait(lambda s: s.paused)
    comes(guest.visitor, "angehalten")


def test_the_language_changes_on_the_page(house: OpenHouse, arrive: Arrive) -> None:
    visitor = arrive(house()).visitor
    open_lessons(visitor)
    comes(visitor, "Leave the lessons")
    visitor.set_value("language", "Slovenščina")
    title = plain(load_lessons(language="sl").lessons[0].steps[0].title)
    for word in ("Zapusti lekcije", title, "Lekcija: zapusti lekcije"):
        comes(visitor, word)
    assert [labels(visitor).count(label) for label in ("jezik", "prizor", "zakon", "ura")] == [1, 1, 1, 1]
    assert not {"language", "scene", "law", "clock", "Leave the lessons"} & set(labels(visitor))
    visitor.set_value("jezik", "English")
    comes(visitor, "Leave the lessons")


def test_a_bad_link_is_named_in_the_page_s_language(house: OpenHouse, arrive: Arrive) -> None:
    visitor = arrive(house(), "lang=sl&dm=9").visitor
    visitor.wait_for(lambda _: notes(visitor))
    assert [note["title"] for note in bodies(visitor, "NotificationShowMessage")] == ["Del povezave je izpuščen"]
    assert "je zunaj območja; mogoče je število od" in notes(visitor)[0]


def test_nothing_of_a_class_is_left_untranslated(house: OpenHouse, join: Join) -> None:
    opened = house(changed(Settings(), "lang", "pseudo"), lecture=True, key="k")
    teacher = join(opened, "key=k")
    comes(teacher, pseudo("Join"))
    others = join(opened), join(opened, "key=wrong")
    for visitor in (teacher, *others):
        comes(visitor, pseudo("Live plots"))
        assert_all_said(visitor)
