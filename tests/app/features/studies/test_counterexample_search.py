"""A counterexample search beside a session: by starts, with replay and link, dropped on changes."""

from urllib.parse import quote

import pytest

from app.features.studies import counterexample_search
from app.features.studies.background_studies import BackgroundStudies
from app.features.studies.compare import attack_query
from app.features.studies.counterexample import SECONDS as LENGTH
from app.features.studies.counterexample import attack_of
from app.features.studies.counterexample_search import NAME, SECONDS, CounterexampleSearch
from app.session.session import Session
from app.settings import ATTACK, Settings, from_query
from controllers.errors import BadSetting
from scenes.rerun import rerun
from tests.app.conftest import Arrive, OpenHouse
from tests.app.inline import Inline
from tests.app.page.helpers import notes, shown
from tests.blocking_client import BlockingClient
from tests.scenes.helpers import given_settings

pytestmark = pytest.mark.slow


def searching(desk: Inline, **settings: object) -> tuple[Session, CounterexampleSearch]:
    session = Session(Settings(given_settings(pairs="single", v=0.05, dt=0.02, **settings)), background=desk)
    search = session.parts.of(BackgroundStudies).counterexample
    search.toggle()
    return session, search


@pytest.mark.thorough
@pytest.mark.parametrize("in_time", [3, 5])
def test_a_search_goes_from_start_to_start_and_ends(
    desk: Inline, monkeypatch: pytest.MonkeyPatch, in_time: int
) -> None:
    """It ends after the starts that fit in the time, but not before a fourth one."""
    monkeypatch.setattr(counterexample_search, "STARTS", 4)
    session, search = searching(desk, seed=7)
    for done in range(1, (starts := max(in_time, 4)) + 1):
        assert search.busy and desk.work("search") == ["search"]
        session.advance(SECONDS if done == in_time else 0.0)
        assert search.worst is not None and search.runs >= 3 * done
    assert not search.busy
    found = [job.result for job in desk.jobs if job.kind == "search"]
    assert (
        search.worst is not None
        and len(found) == starts
        and search.worst.badness == max(one.badness for one in found)
    )
    # In the worst run the closest pair loses centimetres.
    assert search.broken and search.worst.loss.lost > 0.01


def test_the_button_ends_a_search_and_other_settings_drop_it(desk: Inline) -> None:
    session, search = searching(desk)
    desk.work("search")
    session.advance(0.0)
    search.toggle()
    worst = search.worst
    assert not search.busy and worst is not None and not desk.waiting("search")
    session.change("n", 9.0)
    session.advance(0.0)
    assert search.worst is None and search.runs == 0
    search.replay_worst()
    assert not desk.waiting("replay")


def test_the_worst_run_is_replayed_and_its_link_repeats_it(desk: Inline) -> None:
    session, search = searching(desk)
    desk.work("search")
    session.advance(0.0)
    search.replay_worst()
    desk.work("replay")
    session.advance(0.0)
    desk.work("film")
    assert search.worst is not None
    session.player.advance(0.0)
    replay = session.player.replay
    assert replay is not None and session.player.loaded == NAME and replay.end == pytest.approx(LENGTH)
    attack = search.replayed
    assert attack is not None
    query = attack_query(session.settings, attack)
    again, problems = from_query(query, Settings())
    assert not problems and again.run == attack.settings
    table = attack_of(again.run, query[ATTACK]).table()
    assert rerun(replay.recorded).table.tobytes() == table.tobytes()


def test_an_impossible_search_gives_a_reason(desk: Inline) -> None:
    _, search = searching(desk, scene="solo")
    assert not search.busy and "Nothing is in the way" in search.message
    with pytest.raises(BadSetting, match="copy the link again"):
        Session(Settings(), background=desk).parts.of(BackgroundStudies).counterexample.open("1,2")


def press_row(visitor: BlockingClient, label: str, button: str) -> None:
    visitor.wait_for(lambda v: button in v.mirror.labelled(label)["options"])
    visitor.set_value(label, button)


@pytest.mark.thorough
def test_a_link_replays_its_run_on_the_page_and_a_damaged_one_is_named(
    house: OpenHouse, arrive: Arrive
) -> None:
    app = house()
    attack = attack_of(given_settings(dt=0.02), ",".join(["0.1"] * 14 + ["0.5"] * 9))
    link = "&".join(f"{key}={text}" for key, text in {"dt": "0.02", ATTACK: attack.text()}.items())
    one = arrive(app, link)
    one.visitor.wait_for(lambda v: f"This is {NAME}" in shown(v))
    one.wait(lambda s: s.player.replay is not None)
    # The page's own link is the replay's link.
    one.visitor.wait_for(lambda v: f"{ATTACK}={quote(attack.text(), safe='')}" in shown(v))
    other = arrive(app, f"{ATTACK}=1,2")
    other.visitor.wait_for(lambda v: any("copy the link again" in note for note in notes(v)))
    press_row(other.visitor, "try to break it", "Search")
    other.wait(lambda s: s.parts.of(BackgroundStudies).counterexample.runs > 0)
    other.visitor.wait_for(lambda v: "Watch" in v.mirror.labelled("try to break it")["options"])
