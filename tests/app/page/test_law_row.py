"""The laws' plot stays small: one row for the choice and one line for the title, also in a small window."""

import pytest

from tests.app.conftest import OpenHouse
from tests.app.page.by_hand import visit
from tests.browser import PageAt, until

ROWS = """() => {
  const high = (element) => element.getBoundingClientRect().height;
  const chart = document.querySelector(".duet-few-laws");
  const captions = [...document.querySelectorAll(".duet-caption")].filter((one) => one.getClientRects().length);
  return [Boolean(chart), captions.map((one) => high(one) / parseFloat(getComputedStyle(one).fontSize))];
}"""


@pytest.mark.parametrize("language", ["en", "de", "sl"])
def test_the_choice_of_laws_takes_one_row(house: OpenHouse, page_at: PageAt, language: str) -> None:
    page = page_at(1024, 768)
    visit(page, house(), f"plot=laws&panel=small&lang={language}")
    label = {"en": "also draw", "de": "auch zeichnen", "sl": "nariši tudi"}[language]
    row = page.get_by_text(label, exact=True).locator("xpath=ancestor::div[.//input][1]")
    box = row.locator("input[role=combobox], input:visible").first
    until(page, lambda: page.evaluate(ROWS)[0] and box.is_visible(), "the plot and its row")
    lines = page.evaluate(ROWS)[1]
    # In units of the font size: one line has 1.6, two lines have 3.
    assert len(lines) >= 2 and max(lines) < 2.0, lines
    bounds = row.bounding_box()
    assert bounds is not None and bounds["height"] < 40
    if language != "en":
        return
    for entry, said in (
        ("○ 6 Barrier QP", "6 Barrier QP"),
        ("○ 15 Unprotected", "6 Barrier QP, 15 Unprotected"),
        ("● 6 Barrier QP", "15 Unprotected"),
    ):
        box.click()
        page.get_by_role("option", name=entry, exact=True).click()
        until(page, lambda said=said: box.input_value() == said, said)
    until(page, lambda: page.locator(".duet-few-laws path.law15").count() == 1, "its line")
    assert page.locator(".duet-few-laws path.law6").count() == 0
