"""The plot of a search: every try of a challenge is kept, and from the third on drawn, with the bounds that it looks for."""

import re
from dataclasses import replace

from app.lessons.phases import Phase
from app.lessons.reference_runs import simulated
from app.lessons.walkthrough import Walkthrough
from app.page.lessons.lesson_html import attempt_html
from tests.lessons.helpers import our_book


def test_the_third_try_brings_a_plot_that_survives_a_reload() -> None:
    walk = Walkthrough(our_book())
    walk.go("imitation", 1)
    while walk.phase is not Phase.CHALLENGE:
        walk.next()
    for count, v in enumerate((0.1, 0.3, 0.35), 1):
        walk.attempt(simulated(walk.setup.with_changes((("v", v),))))
        assert [one.setting for one in walk.done.tries] == [0.1, 0.3, 0.35][:count]
        assert ("<svg" in attempt_html(walk.view())) is (count >= 3)
    walk.attempt(simulated(replace(walk.setup, seconds=1.0)))
    assert walk.done.last is not None and walk.done.last.note and len(walk.done.tries) == 3, "a run that does not count is no try"
    assert [one.met for one in walk.done.tries] == [False, False, True]
    html = attempt_html(walk.view())
    assert html.count('class="missed"') == 2 and html.count('class="met"') == 1 and html.count('class="bound"') == 2
    xs = [float(x) for x in re.findall(r'class="missed" d="M([0-9.]+)', html)]
    assert xs[0] < xs[1] < float(re.findall(r'class="met" cx="([0-9.]+)"', html)[0])
    assert "Your tries: 3" in html and ">0.1<" in html and ">0.36<" in html
    assert Walkthrough.from_json(walk.book, walk.to_json()).done.tries == walk.done.tries
