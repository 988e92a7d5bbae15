"""A replay equals the run to the last bit."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.plots.time_series import COLUMNS, RollingSeries
from app.session import replay as replay_module
from app.session.replay import PERIOD, Replay, make_film
from scenes.history import COLUMN
from scenes.inputs import encoded
from tests.app.recording.runs import SCENES, piece


@pytest.mark.parametrize("scene", SCENES)
def test_any_replayed_moment_equals_the_run(scene: str) -> None:
    recorded, table = piece(scene, 3.0, 1.6, lively=True)
    replay = Replay(make_film(recorded))
    targets = [encoded(target) for target in recorded.targets()]
    generator = np.random.default_rng(3)
    for step in (
        1,
        2,
        recorded.steps,
        recorded.steps - 1,
        7,
        *generator.integers(1, recorded.steps + 1, 12).tolist(),
    ):
        replay.seek_step(step)
        assert replay.simulation.history.table(1)[0].tobytes() == table[step - 1].tobytes()
        assert replay.step == step and encoded(replay.target) == targets[step - 1]
        assert replay.time == pytest.approx(replay.simulation.time, abs=1e-9)
        ends = np.cumsum([stretch.targets.steps for stretch in recorded.stretches])
        assert replay.simulation.settings == recorded.stretches[int(np.searchsorted(ends, step))].settings


@cache
def lively() -> Replay:
    return Replay(make_film(piece("hold", 3.0, 99.0, lively=True)[0]))


@settings(max_examples=40)
@given(st.floats(allow_nan=True, allow_infinity=True))
def test_any_time_has_a_nearest_moment(time: float) -> None:
    replay = lively()
    step = replay.nearest(time)
    assert 1 <= step <= replay.steps
    if replay.begin <= time <= replay.end:
        assert abs(replay.moment(step) - time) <= 0.0026


def test_every_step_has_its_time_and_every_time_its_step() -> None:
    replay = lively()
    times = [replay.moment(step) for step in range(1, replay.steps + 1)]
    assert (np.diff(times) > 0.0).all() and (replay.begin, replay.end) == (times[0], times[-1])
    assert [replay.nearest(time) for time in times] == list(range(1, replay.steps + 1))
    for time, step in ((-5.0, 1), (99.0, replay.steps), (float("nan"), 1), (float("inf"), replay.steps)):
        replay.seek(time)
        assert replay.step == step
    replay.seek_step(-3)
    assert replay.step == 1
    # A row of the table has the time before its step.
    _, table = piece("hold", 3.0, 99.0, lively=True)
    np.testing.assert_allclose(times[:-1], table[1:, COLUMN["t"]], atol=1e-9)


def test_playing_makes_every_step_and_stops_at_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(replay_module, "BUDGET", float("inf"))
    recorded, table = piece("hold")
    replay = Replay(make_film(recorded))
    replay.advance(1.0)
    assert replay.step == 1
    replay.toggle()
    replay.advance(0.1)
    assert replay.step == 21 and replay.playing
    replay.speed = 0.5
    replay.advance(0.1)
    assert replay.step == 31
    while replay.playing:
        replay.advance(0.02)
    replay.advance(1.0)
    assert replay.step == replay.steps
    assert replay.simulation.history.table().tobytes() == table.tobytes()
    replay.toggle()
    assert replay.playing and replay.step == 1


def test_playing_leaves_time_for_other_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(replay_module, "BUDGET", 0.0)
    replay = Replay(make_film(piece("hold")[0]))
    replay.toggle()
    replay.advance(1.0)
    assert replay.step == 1 + 8 and replay.playing
    # Missed steps are not made up.
    replay.advance(0.015)
    assert replay.step == 1 + 8 + 3


def test_plots_of_a_replay_show_the_past_and_keep_every_dip() -> None:
    recorded, table = piece("hold", 6.0)
    replay = Replay(make_film(recorded))
    buffer = RollingSeries()
    for time in (5.5, 2.0, 5.0):
        replay.seek(time)
        buffer.feed(replay.simulation)
        times, distances = buffer.newest([COLUMNS["d"]])
        assert times[-1] == pytest.approx(time, abs=0.02) and times[0] < 0.2
        live = table[: replay.step]
        # The same bins as in the live run, with the smallest distance of each.
        bins = np.unique((live[:, COLUMN["t"]] * 8.0).astype(int), return_index=True)[1]
        np.testing.assert_array_equal(distances, np.minimum.reduceat(live[:, COLUMN["d"]], bins))


@pytest.mark.parametrize(("seconds", "states"), [(6.0, 4000), (1.0, 7)])
def test_a_film_has_few_states_and_the_nearest_rows(
    monkeypatch: pytest.MonkeyPatch, seconds: float, states: int
) -> None:
    monkeypatch.setattr(replay_module, "MOST_STATES", states)
    recorded, table = piece("hold", seconds)
    kept = make_film(recorded)
    assert (
        len(kept.states)
        == min(-(-recorded.steps // replay_module.SPACING), states)
        == -(-recorded.steps // kept.spacing)
    )
    assert len(kept.rows) == pytest.approx(seconds / PERIOD, abs=1)
    for row, step in zip(kept.rows, kept.row_steps.tolist(), strict=True):
        assert row.tobytes() == table[step].tobytes()
    assert kept.rows[:, COLUMN["d"]].min() == table[:, COLUMN["d"]].min()
    replay = Replay(kept)
    for step in (150, 20, 199):
        replay.seek_step(step)
        assert replay.simulation.history.table(1)[0].tobytes() == table[step - 1].tobytes()
