"""Pages with another first task never mention the distance of two arms, in any language, law or plot."""

import html
import json
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import pytest

from app.features.custom_law.trials import WHY
from app.features.formula_law.formula_editor import CALLED_OF_A_VALUE
from app.i18n.catalogue import words_of
from app.i18n.speaking import set_language, tr
from app.page.panels.choice_buttons import MARK
from app.page.panels.plots_panel import PERIOD as PLOTS
from app.page.panels.readout import PERIOD as READOUT
from app.plots.plot_choice import possible_details
from app.session.actions import Describe
from app.session.relevant_settings import matters
from app.settings import Language, PageSettings, Settings
from app.text.first_task_texts import FIRST_TASK_TEXTS, in_unit, said_of
from app.theme import SYMBOLS
from app.web.headless_client import HeadlessClient
from scenes.laws import LAWS
from scenes.quantities import ALL, FIRST_TASKS, PARTS, TIP, WALL
from scenes.settings import LawSettings, RunSettings, specs
from tests.app.conftest import Arrive, OpenHouse

VISITS = [(language, first) for first in FIRST_TASKS for language in ("en", "de", "sl")]

OF_DISTANCE = {
    "en": r"distance|\bpairs?\b|\bgap\b|closest|nearer|\bapart\b|overlap|other arm|obstacle",
    "de": r"abst[aä]nd|\bpaare?n?\b|lücke|näher|überlapp|ander\w+ arm|hindernis",
    "sl": r"razdalj|\bpar(?:a|u|om|i|ov|oma)?\b|\bvrzel|bliž|prekriv|drug\w+ (?:roka|robot)|ovir",
}
"""Words about the distance of two arms."""

SYMBOL = r"(?<!\w)d(?:m|0|law|min)?(?!\w)|dₘ|Jd\b"
"""Symbols of that distance and of its row, without underscores."""

OF_THE_HAND = r"\|e\|(?: =)?(?: \d+ mm)+(?: \(\w+ \d+ mm\))?|[+−]?\d+ mm/s|wmax \[m/s\]"
"""Lengths and speeds of the hand."""


def strings(value: Any) -> Iterator[str]:
    """All words of a JSON value."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        for one in value:
            yield from strings(one)
    elif isinstance(value, str) and value not in SYMBOLS and not value.startswith(("/", "where(")):
        # Types, node names and the editor's formula are skipped.
        yield value


def texts_of(element: dict[str, Any]) -> Iterator[str]:
    """Visible texts of one element of the page."""
    for name in ("label", "hint", "title", "body"):
        yield str(element.get(name) or "")
    yield from (str(one) for one in element.get("options") or ())
    if element["type"] != "GuiButtonGroupMessage" and isinstance(element.get("value"), str):
        yield str(element["value"])
    content = re.sub(r"<style>.*?</style>", "", str(element.get("content") or ""), flags=re.S)
    for data in re.findall(r'data-[a-z]+="([^"]*)"', content):
        try:
            yield from strings(json.loads(html.unescape(data)))
        except ValueError:
            continue
    # A subscript is kept with its symbol.
    content = re.sub(r"</?sub>", "", re.sub(r"<b[^>]*>d</b>", "d", content)).replace(" ", " ")
    for line in re.sub(r"<[^>]+>", " ", content).splitlines():
        yield " ".join(html.unescape(line).split())


def left_over(text: str, language: Language, first: str) -> list[str]:
    """Parts of a text that refer to the distance of two arms."""
    text = text.replace("_", "")
    if first == WALL:
        # The wall's task is also a distance, with another row.
        return re.findall(r"Jd\b", text)
    units = "" if first in (TIP, ALL) else r"|\bmm\b(?!/)|(?<![\w/])m/s|\[m\]"
    return re.findall(
        f"{SYMBOL}|{OF_DISTANCE[language]}{units}", re.sub(OF_THE_HAND, "", text), re.IGNORECASE
    )


def test_left_overs_are_found() -> None:
    assert left_over("the closest pair", "en", "stops") == ["closest", "pair"]
    assert left_over("critical value h_m [mm]", "en", "stops") == ["mm"]
    assert left_over("Abstände über d_m", "de", "all") == ["Abständ", "dm"]
    assert left_over("u in m/s", "sl", "singular") == ["m/s"]
    assert left_over("Jd stays", "en", "wall") and not left_over("d_m [mm]", "en", "wall")
    assert not left_over("h_m [mrad], |e| 34 mm, and rad/s; it did", "en", "stops")
    assert list(
        texts_of({"type": "", "content": '<i data-w="{&#34;a&#34;:&#34;x&#34;}">J<sub>d</sub></i>'})
    ) == [
        *[""] * 4,
        "x",
        "Jd",
    ]


def right_texts(language: Language, first: str) -> list[str]:
    """Permitted texts with a distance or d: of the first task, minimum, formulas and tests of a law."""
    kept, say = FIRST_TASKS[first], words_of(language)
    parts = PARTS.get(first, (first,))
    texts = [
        *(say(text) for part in parts for text in FIRST_TASK_TEXTS[part]),
        *(say(text) for text in ("violet plane: distance to keep",) if first == ALL),
        say("No joint comes near its stops."),
        say("Sharpness of the smooth minimum; larger is closer to the true minimum."),
        say(CALLED_OF_A_VALUE, symbol=kept.symbol),
        say("v, d_m and n are those of the settings; the tests take 0.30 m/s, 0.15 m and 6."),
        say("Functions: where(d < d_m, 1, 0), min, max, clip, abs, exp, log, sqrt, tanh."),
        *(say(text) for pair in WHY.items() for text in pair),
    ]
    return sorted((text.replace("_", "") for text in texts), key=len, reverse=True)


def without(text: str, right: list[str]) -> str:
    text = text.replace("_", "").replace("\N{NO-BREAK SPACE}", " ")
    for one in right:
        text = text.replace(one, "")
    return text


@pytest.mark.parametrize(("language", "first"), VISITS)
def test_settings_do_not_mention_the_distance_of_two_arms(language: Language, first: str) -> None:
    set_language(language)
    kept, right = FIRST_TASKS[first], right_texts(language, first)
    say = said_of(kept)
    settings = Settings(RunSettings(scene="first_task", first=first))
    found = {}
    for law in LAWS:
        run = replace(settings.run, law=LawSettings(law=law))
        for key, spec in specs(Settings).items():
            if not matters(key, replace(settings, run=run)):
                continue
            shown = in_unit(spec, kept)
            texts = (shown.title(say), say(shown.help), *map(say, shown.options().values()))
            wrong = [one for text in texts for one in left_over(without(text, right), language, first)]
            if wrong:
                found[key] = wrong
    assert found == {}


@pytest.mark.thorough
@pytest.mark.parametrize(("language", "first"), VISITS)
def test_pages_do_not_mention_the_distance_of_two_arms(
    house: OpenHouse, arrive: Arrive, language: Language, first: str
) -> None:
    set_language(language)
    guest = arrive(house(), f"scene=first_task&first={first}&lang={language}&ghost=frozen&whatif=1")
    kept, right = FIRST_TASKS[first], right_texts(language, first)
    law_label, laws = tr("law"), in_unit(specs()["law"], kept).options()
    found: dict[str, list[str]] = {}
    seen: set[str] = set()

    def look(visitor: HeadlessClient) -> set[str]:
        """All visible texts; wrong ones are added to `found`."""
        shown = {
            text
            for element in list(visitor.mirror.gui.values())
            if element.get("visible") is not False
            for text in texts_of(element)
        }
        for text in shown - seen:
            if wrong := left_over(without(text, right), language, first):
                found[text] = wrong
        seen.update(shown)
        return shown

    def change(key: str, value: object, there: Callable[[HeadlessClient], object]) -> None:
        guest.ask(lambda session: session.change(key, value))
        guest.visitor.wait_for(there)
        # Numbers are refreshed a moment later.
        guest.run_on(READOUT + PLOTS)
        guest.visitor.wait_for(look)

    run = RunSettings(scene="first_task", first=first)
    for plot in possible_details(run):
        label = MARK + said_of(kept)(specs(PageSettings)["plot"].options()[plot])
        change("plot", plot, lambda visitor, label=label: label in look(visitor))
    guest.session.post(Describe())
    guest.visitor.wait_for(lambda visitor: any(f"{kept.symbol} = " in text for text in look(visitor)))
    change("dm", 0.3, lambda visitor: look(visitor) and "300" in str(visitor.mirror.gui))
    for law in LAWS:
        label = said_of(kept)(laws[law])
        change("law", law, lambda visitor, label=label: visitor.mirror.labelled(law_label)["value"] == label)
    assert len(seen) > 150
    assert found == {}
