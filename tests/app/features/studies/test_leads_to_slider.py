"""How a question leads to its slider."""

from app.features.studies.compare import flash_html


def test_the_slider_and_its_closed_tab_flash() -> None:
    made = str(flash_html((("slider-1", "tab-2"),)))
    assert 'label[for="slider-1"]' in made and '[data-dock-tab="tab-2"][aria-selected=false]' in made
    assert "animation:var(--duet-flash)" in made and flash_html(()) == ""
