"""Numbers that viser's client writes, or a visitor types, have the decimal sign of the page's language."""

import pytest

from app.settings import Language
from tests.app.conftest import OpenHouse, ask
from tests.app.page.by_hand import LATE_UPDATE, visit
from tests.browser import PageAt, until

_LISTEN = """window.drawn = new Set();
const draw = CanvasRenderingContext2D.prototype.fillText;
CanvasRenderingContext2D.prototype.fillText = function (text, ...where) {
  if (this.canvas.closest(".uplot")) drawn.add(text);
  draw.call(this, text, ...where);
};"""
_SEEN = """() => {
  // Another window's, which the page has not changed.
  const frame = document.body.appendChild(document.createElement("iframe"));
  const { get } = Object.getOwnPropertyDescriptor(frame.contentWindow.HTMLInputElement.prototype, "value");
  const seen = [...document.querySelectorAll(".mantine-NumberInput-input")].map((box) => get.call(box));
  frame.remove();
  return seen.concat([...document.querySelectorAll(".mantine-Slider-markLabel")].map((end) => end.textContent));
}"""


@pytest.mark.thorough
def test_boxes_sliders_and_axes_have_the_languages_decimal_sign(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1024, 768, fresh=True, expect=(LATE_UPDATE,))
    page.add_init_script(_LISTEN)
    session = visit(page, house(), "lang=de&panel=all&v=0.35&scene=imitation")
    languages: dict[Language, tuple[str, str]] = {"sl": (",", "."), "en": (".", ","), "de": (",", ".")}
    for language, (sign, other) in languages.items():
        ask(session, lambda s, language=language: s.change("lang", language))

        def boxes(sign: str = sign, other: str = other) -> bool:
            seen = page.evaluate(_SEEN)
            return any(sign in number for number in seen) and not any(other in number for number in seen)

        until(page, boxes, "the language's sign in every box")
        page.evaluate("drawn.clear()")
        until(
            page,
            lambda sign=sign: f"0{sign}2" in page.evaluate("[...drawn]"),
            "the language's sign at an axis",
        )
        assert not [text for text in page.evaluate("[...drawn]") if text.startswith(f"0{other}")]
    # No tick is rounded: the axis and the steps between ticks have three decimals.
    ask(session, lambda s: s.reset())
    until(page, lambda: "0,005" in page.evaluate("[...drawn]"), "an error of little")
    assert "0,003" not in page.evaluate("[...drawn]")
    (number,) = [i for i, seen in enumerate(page.evaluate(_SEEN)) if seen == "0,35"]
    box = page.locator(".mantine-NumberInput-input").nth(number)
    for typed, velocity in (("0,25", 0.25), ("0.2", 0.2)):
        box.fill(typed)
        box.press("Tab")
        until(page, lambda velocity=velocity: session.settings.run.law.nominal_velocity == velocity, "v")
        until(
            page,
            lambda velocity=velocity: f"{velocity:g}".replace(".", ",") in page.evaluate(_SEEN),
            "the language's sign again",
        )
