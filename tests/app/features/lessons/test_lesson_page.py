"""The lessons' page on the server's side: texts, pictures, links, buttons and input."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import MagicMock

import pytest

from app.features.lessons.bookmark import Phase
from app.features.lessons.folder import FOLDER
from app.features.lessons.loading import load_lessons
from app.features.lessons.panel.answer_boxes import read_number
from app.features.lessons.panel.lesson_charts import search_plot
from app.features.lessons.panel.lesson_controls import LessonControls
from app.features.lessons.panel.lesson_html import attempt_html, blocks_html
from app.features.lessons.panel.lesson_keys import LESSON_KEYS
from app.features.lessons.panel.lesson_panel import ORDER, LessonPanel
from app.features.lessons.panel.lesson_visit import open_link
from app.features.lessons.progress import Try
from app.features.lessons.reference_runs import simulated
from app.features.lessons.session.lesson_actions import GoTo, Press, SayNumber
from app.features.lessons.session.lesson_session import LessonSession
from app.features.lessons.walkthrough import Walkthrough
from app.i18n.speaking import set_language
from app.page.panels.choice_buttons import MARK
from app.page.panels.hotkeys import hotkeys
from app.session.frame import freeze
from app.session.session import Session
from app.settings import LANGUAGES, Language, Settings
from app.text.formula import formula, plain_formula
from app.text.lesson_text import left_dollar, lesson_html, plain
from app.text.picture import PICTURE, picture_html
from app.text.templates import macros
from scenes.settings import changed, values
from tests.app.conftest import Arrive, OpenHouse, ask
from tests.app.features.lessons.helpers import lessons_of, our_book, to_challenge
from tests.app.page.helpers import Client, bodies, buttons, click, page_label, shown

pytestmark = pytest.mark.slow

BOOK = our_book()


def test_html_in_a_lesson_file_is_escaped() -> None:
    made = lesson_html(
        "a <script>alert(1)</script> *b <i>c</i>* `<d>` $x<y$\n\n- <e>\n\n![<f>](g.svg)", Path("/nowhere")
    )
    for bad in ("<script", "<i>", "<d>", "<e>", "<f>"):
        assert bad not in made
    assert "<em>b" in made and "<svg" in made


@pytest.mark.thorough
@pytest.mark.parametrize("language", LANGUAGES)
def test_all_pictures_and_formulas_of_all_steps_are_drawn(language: Language) -> None:
    book = load_lessons(language=language)
    walk, shown = Walkthrough(book), list[str]()
    while True:
        shown += blocks_html(walk.view(), (), False, False).values()
        question = walk.step.question
        if question is not None and walk.locked:
            walk.choose(question.right)
        while walk.hint():
            pass
        shown += blocks_html(walk.view(), (), False, False).values()
        if not walk.next():
            break
    steps = [step for lesson in book.lessons for step in lesson.steps]
    shown += [
        lesson_html(choice.reply)
        for step in steps
        if step.question is not None
        for choice in step.question.choices
    ]
    shown += [
        lesson_html(text) for lesson in book.lessons for text in (lesson.goal, lesson.promise, lesson.learned)
    ]
    made = "".join(shown)
    assert "![" not in made and "$" not in made and "\\" not in made, (
        "some source text of a picture or formula is left"
    )
    named = {found for step in steps for found in PICTURE.findall(f"{step.observe}\n{step.explain}")}
    assert {name.removesuffix(".svg").removesuffix(f".{language}") for _, name in named} == {
        f"pictures/{name}" for name in ("elbow", "jump", "line", "lever", "kinks")
    }
    for words, name in named:
        picture = picture_html(FOLDER, name, words)
        assert (
            'class="d' in picture
            and "currentColor" in picture
            and picture.startswith("<svg ")
            and picture in made
        )


def test_a_formula_may_continue_on_the_next_line() -> None:
    (one,) = re.findall("<svg.*?</svg>", lesson_html("jumps by $(v + u)/\\|J_d\\|$ once"), re.DOTALL)
    for text in (
        "jumps by $(v +\nu)/\\|J_d\\|$ once",
        "jumps by $(v\n+ u)/\\|J_d\\|$ once",
        "- jumps by $(v\n  + u)/\\|J_d\\|$ once",
    ):
        made = lesson_html(text)
        assert one in made and "$" not in made and made.count("<li>") == text.startswith("-")
        assert left_dollar(text) is None
    assert plain("by $v\n+ u$") == "by v + u"
    for text, line in (
        ("a\n$x\n\ny$", 1),
        ("$x$ $$y", 0),
        ("`$` \\$ $$a\n+ b$$\n\n```\n$HOME\n```\n", None),
        ("~~~\n$\n~~~\n$", 3),
    ):
        assert left_dollar(text) == line


def test_an_svg_with_more_than_shapes_is_not_inlined(tmp_path: Path) -> None:
    head = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1 1"'
    picture = tmp_path / "a.svg"
    for rest in (
        "><script>alert(1)</script></svg>",
        ' onload="alert(1)"/>',
        '><g><path d="M0 0" onclick="alert(1)"/></g></svg>',
        '><foreignObject><p xmlns="http://www.w3.org/1999/xhtml">x</p></foreignObject></svg>',
        '><path style="fill:red" d="M0 0"/></svg>',
        '><path fill="url(https://example.org/x)" d="M0 0"/></svg>',
        '><path id="duet-say" d="M0 0"/></svg>',
        ' xmlns:xlink="http://www.w3.org/1999/xlink"><image xlink:href="https://example.org/x"/></svg>',
    ):
        picture.write_text(head + rest, encoding="utf-8")
        made = lesson_html('![a "b" <c>](a.svg)', tmp_path)
        assert re.fullmatch(
            r'<img alt="a &quot;b&quot; &lt;c&gt;" src="data:image/svg\+xml;base64,[\w+/=]+">', made
        )
    picture.write_text(f"{head}><title>x</title><text>&lt;b&gt;</text></svg>", encoding="utf-8")
    made = lesson_html('![a "b"](a.svg)', tmp_path)
    assert (
        made
        == '<svg class="picture" role="img" aria-label="a &quot;b&quot;" viewBox="0 0 1 1"><text>&lt;b&gt;</text></svg>'
    )


def test_symbols_have_their_colours_and_a_name() -> None:
    made = formula(r"\dot d = \lambda v - (1 - \lambda) u - w", True)
    for name in ("lam", "v", "u", "w"):
        assert f'class="{name}"' in made
    assert 'role="img"' in made and "λ" in made and "λ" in plain_formula(r"\lambda")
    assert made.count('class="d"') == 0, "the rate of d does not have the class of d"
    d = re.compile('class="d"')
    for tex, count in (
        (r"\lambda(d) = \left(\dfrac{d_m}{d}\right)^{n}", 2),
        (r"d \geq d_{law} \geq d_m", 1),
        (r"\dot d = -a (d - d^*)", 1),
        (r"J_d\,\dot q + J_{d,i}\,\mathrm{d}t + \ddot d + \dot{d} = \min_i d_i", 0),
    ):
        assert len(d.findall(formula(tex, True))) == count, tex
    assert plain("*half* of $d_m$, **not** `all`") == "half of dₘ, not all"


@pytest.mark.parametrize(
    ("text", "number"),
    [
        *(
            ("0.5", 0.5),
            ("0,5 rad/s", 0.5),
            ("−2", -2.0),
            ("", None),
            ("x", None),
            ("nan", None),
            ("1e99", None),
        ),
        *(
            ("0.42rad/s", 0.42),
            ("30°", 30.0),
            (" 50% ", 50.0),
            ("0,5\u00a0m", 0.5),
            ("1e-3\u202fm", 1e-3),
            (".5", 0.5),
        ),
        *(("1.000,5", None), ("1 000", None), (5.0, None)),
    ],
)
def test_typed_numbers_are_read_with_units_and_local_signs(text: object, number: float | None) -> None:
    assert read_number(text) == number


def test_a_contrast_run_hides_the_numbers_of_the_questions_run() -> None:
    walk = Walkthrough(BOOK)
    walk.go("smooth")
    walk.choose(1)
    walk.observe(simulated(walk.setup))
    assert "The hand rests" in blocks_html(walk.view(), (), False, True)["after"]
    assert walk.show_why() and not blocks_html(walk.view(), (), False, True)["after"]


@pytest.mark.thorough
@pytest.mark.parametrize("ghost", ["off", "frozen", "own"])
def test_the_panel_survives_any_ghost_after_a_skipped_lever_run(ghost: str) -> None:
    session = Session(Settings())
    run = LessonSession(session, BOOK)
    lesson, step = next(
        (i, k) for i, one in enumerate(BOOK.lessons) for k, each in enumerate(one.steps) if each.at_lever
    )
    run.enter(lesson, step)
    while run.walk.phase is not Phase.OBSERVE:
        if run.walk.locked:
            run.walk.choose(0)
        assert run.walk.next()
    panel = LessonPanel(MagicMock(), run, 340.0, True)
    panel.show(freeze(session, 0.0))
    assert panel.run_names is not None
    session.change("ghost", ghost)
    panel.show(freeze(session, 1.0))
    assert panel.run_names is None


def test_a_number_stays_with_its_step_even_if_it_arrives_late(house: OpenHouse, arrive: Arrive) -> None:
    number, index = next(
        (n, i) for n, one in enumerate(BOOK.lessons, 1) for i, s in enumerate(one.steps) if s.id == "forecast"
    )
    one = arrive(house(), f"lesson={number}&step={index + 1}")
    visitor, run = one.visitor, lessons_of(one)

    def asks() -> bool:
        to_challenge(run.walk)
        run.version += 1
        return run.walk.challenge is not None

    def to_box() -> None:
        one.wait(lambda _: run.open and run.walk.step.id == "forecast")
        assert one.ask(lambda _: asks())
        visitor.wait_for(lambda _: box().get("visible"))

    def box() -> dict[str, Any]:
        elements = list(visitor.mirror.gui.values())
        return next((one for one in elements if str(one.get("hint", "")).startswith("Your number")), {})

    to_box()
    label = str(box()["label"])
    visitor.set_value(label, "0,25 m")
    one.wait(lambda _: run.said == [0.25])
    one.ask(lambda _: run.act(GoTo(None, index - 1)))
    visitor.wait_for(lambda _: not box()["visible"])
    visitor.set_value(label, "0.5")
    one.wait(lambda _: run._said["strict-priority", "forecast"] == [0.5] and run.said == [])
    one.ask(lambda _: run.act(SayNumber("strict-priority", "forecast", 0, 0.75)))
    one.ask(lambda _: run.act(GoTo(None, index)))
    to_box()
    visitor.wait_for(lambda _: box()["value"] == "0.75")


def test_keys_and_their_texts_are_unique() -> None:
    keys = (*hotkeys(), *LESSON_KEYS)
    assert (
        len({(h.key, bool(h.relayed)) for h in keys})
        == len({h.text for h in keys})
        == len({h.name for h in keys})
        == len(keys)
    )
    assert len({h.shown for h in hotkeys()}) == len(hotkeys())


def test_a_link_opens_a_step_and_leaving_restores_the_visitors_settings(
    house: OpenHouse, arrive: Arrive
) -> None:
    one = arrive(house(), "lesson=3&step=2")
    visitor, run = one.visitor, lessons_of(one)
    visitor.wait_for(lambda v: len(v.mirror.commands) == len(hotkeys()) + len(LESSON_KEYS))
    assert (run.walk.lesson.id, run.walk.step.id) == ("strict-priority", "switch")
    # A lesson offers only the plots of its step.
    visitor.wait_for(lambda v: not v.mirror.labelled("more plots")["visible"])
    visitor.wait_for(lambda _: "Run (predict first)" in buttons(visitor))
    click(visitor, "Leave")
    visitor.wait_for(
        lambda v: not run.open and v.mirror.labelled("more plots")["visible"] and "Lessons" in buttons(v)
    )
    # The browser sets the language.
    assert changed(one.session.settings, "lang", "auto") == Settings()


def test_the_settings_of_a_step_are_in_the_lessons_panel(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house(), "lesson=6&step=3")
    visitor, session = one.visitor, one.session

    def controls(v: Client) -> list[dict[str, Any]]:
        return [
            element for element in list(v.mirror.gui.values()) if element.get("label") == page_label("wmax")
        ]

    visitor.wait_for(lambda v: [c["visible"] for c in controls(v)] == [True, True])
    theirs, ours = controls(visitor)
    assert ours["container_uuid"] != theirs["container_uuid"]
    assert ORDER["choices"] < ours["order"] < ORDER["verdict"], "the settings are above Run"
    visitor.send({"type": "GuiUpdateMessage", "uuid": ours["uuid"], "updates": {"value": 0.4}})
    visitor.wait_for(lambda _: values(session.settings)["wmax"] == 0.4)
    # Both controls show a change of either one.
    visitor.wait_for(lambda v: controls(v)[0]["value"] == 0.4)
    visitor.send({"type": "GuiUpdateMessage", "uuid": theirs["uuid"], "updates": {"value": 0.3}})
    visitor.wait_for(lambda v: controls(v)[1]["value"] == 0.3)
    ask(session, lambda _: lessons_of(one).act(GoTo(None, 0)))
    visitor.wait_for(lambda v: [c["visible"] for c in controls(v)] == [True, False])


def test_a_projector_has_a_wider_lesson_and_higher_plots(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house(), "lesson=1&step=1")

    def sizes(v: Client) -> tuple[list[str], list[int]]:
        return re.findall(r":root{--duet-left:(\d+)px", shown(v)), [
            plot["height"] for plot in bodies(v, "GuiUplotMessage")
        ]

    one.visitor.wait_for(lambda v: all(sizes(v)))
    (wide,), heights = sizes(one.visitor)
    one.ask(lambda s: s.change("profile", "projector"))
    one.visitor.wait_for(
        lambda v: sizes(v) == ([f"{1.3 * int(wide):g}"], [round(1.12 * height) for height in heights])
    )


def test_a_bad_link_is_named_and_the_page_works(house: OpenHouse, arrive: Arrive) -> None:
    guest = arrive(house(), "lesson=%3Cb%3E")
    assert not lessons_of(guest).open
    guest.run_on(0.1)
    run = LessonSession(Session(Settings()), BOOK)
    assert "step = 2 also needs lesson" in open_link(run, {"step": "2"}, None)[0] and not run.open
    assert "choose from 1" in open_link(run, {"lesson": "99"}, None)[0] and not run.open
    assert (
        open_link(run, {"lesson": "1", "step": "x"}, None) and run.open and run.walk.lesson is BOOK.lessons[0]
    )
    assert (
        open_link(run, {"lesson": "strict-priority", "step": "2"}, None) == ()
        and run.walk.step.id == "switch"
    )
    open_link(run, {"lesson": "1", "step": "77"}, None)
    assert run.session.notices


def test_the_plot_of_attempts_has_the_readers_decimal_sign() -> None:
    set_language("de")
    walk = Walkthrough(our_book())
    walk.go("imitation", 1)
    assert walk.step.challenge is not None
    made = search_plot(walk.step.challenge, (Try(0.1, 0.0, False), Try(0.35, 0.1, True)), "de")
    assert ">0,1<" in made and not re.search(r">-?\d+\.\d+<", made)


def test_the_third_attempt_adds_a_plot_that_survives_a_reload() -> None:
    walk = Walkthrough(our_book())
    walk.go("imitation", 1)
    while walk.phase is not Phase.CHALLENGE:
        walk.next()
    for count, v in enumerate((0.1, 0.3, 0.35), 1):
        walk.run_again()
        walk.attempt(simulated(walk.setup.with_changes((("v", v),))))
        assert [one.setting for one in walk.done.tries] == [0.1, 0.3, 0.35][:count]
        assert ("<svg" in attempt_html(walk.view())) is (count >= 3)
    walk.attempt(simulated(replace(walk.setup, seconds=1.0)))
    assert walk.done.last is not None and walk.done.last.note and len(walk.done.tries) == 3, (
        "an invalid run does not add an attempt"
    )
    assert [one.met for one in walk.done.tries] == [False, False, True]
    html = attempt_html(walk.view())
    assert (
        html.count('class="missed"') == 2
        and html.count('class="met"') == 1
        and html.count('class="bound"') == 2
    )
    xs = [float(x) for x in re.findall(r'class="missed" d="M([0-9.]+)', html)]
    assert xs[0] < xs[1] < float(re.findall(r'class="met" cx="([0-9.]+)"', html)[0])
    assert "Your tries: 3" in html and ">0.1<" in html and ">0.36<" in html
    assert Walkthrough(walk.book, walk.to_json()).done.tries == walk.done.tries


def test_a_number_compared_with_three_others_becomes_a_table() -> None:
    lines = (
        "Smallest d: 14 mm; with n = 1: 30 mm; with n = 20: 1.3 mm; with law = <b>: 41 mm.",
        "Largest e: 3 mm; with n = 1: 9 mm.",
    )
    made = str(macros("features/lessons/panel/lesson.html").paragraphs(lines)).replace("\u00a0", " ")
    cells = re.findall(r"<td>(.*?)</td>", made)
    assert (
        cells[:2] == ["Smallest d:", "14 mm"]
        and cells[-2:] == ["with law = &lt;b&gt;:", "41 mm"]
        and len(cells) == 8
    )
    assert "<p>Largest e: 3 mm; with n = 1: 9 mm.</p>" in made


def test_a_lessons_run_waits_while_a_replay_loads() -> None:
    controls = MagicMock()
    for coming, begins in (("a push from a link", False), ("", True)):
        controls._session.player.coming = coming
        LessonControls._act(controls, Press("run"))
        assert controls._run.act.called == begins


def test_every_step_of_the_longest_lesson_has_a_button(house: OpenHouse, arrive: Arrive) -> None:
    counts = [len(lesson.steps) for lesson in BOOK.lessons]
    longest, count = counts.index(max(counts)) + 1, max(counts)
    guest = arrive(house(), f"lesson={longest}&step={count}")
    expected = [*map(str, range(1, count)), f"{MARK}{count}"]
    guest.visitor.wait_for(lambda v: list(v.mirror.labelled("step")["options"]) == expected)
