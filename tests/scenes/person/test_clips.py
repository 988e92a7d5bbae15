"""Clips and sampled people, between and outside their samples."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from controllers.errors import BadSetting
from scenes.person.angles import arm_points
from scenes.person.clips import CLIP_NAMES, REST, Clip, ClipName
from scenes.person.source import PersonSource, SampledAngles

SEEDS = (0, 1, 2, 17, -3)


@pytest.mark.parametrize("name", CLIP_NAMES)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_clip_is_a_loop_from_rest_to_rest(name: ClipName, seed: int) -> None:
    clip = Clip(name, seed)
    assert_allclose(clip.angles(0.0), REST, atol=1e-12)
    assert_allclose(clip.angles(clip.duration), REST, atol=1e-9)
    for t in (0.0, 1.3, 0.7 * clip.duration):
        assert_allclose(clip.angles(t + 2.0 * clip.duration), clip.angles(t), atol=1e-9)
    assert np.abs(clip.angles(0.5 * clip.duration) - REST).max() > 0.01


@pytest.mark.parametrize("name", CLIP_NAMES)
def test_smoothness_and_seeds(name: ClipName) -> None:
    # Steps of the second differences shrink with h: the acceleration has no jump, also at the seam.
    clip = Clip(name, 3)

    def roughest(h: float) -> float:
        times = np.arange(-0.5, clip.duration + 0.5, h)
        q = np.array([clip.angles(t) for t in times]).reshape(len(times), -1)
        return float(np.abs(np.diff(np.diff(q, 2, axis=0) / h**2, axis=0)).max())

    coarse, fine = roughest(0.01), roughest(0.005)
    assert fine < 0.65 * coarse and coarse < 5.0
    # The same seed gives the same bits in any order; another seed gives another motion.
    a, b = Clip(name, 5), Clip(name, 5)
    times = (3.0, 0.2, 7.5, 3.0)
    assert_array_equal([a.angles(t) for t in times], [b.angles(t) for t in reversed(times)][::-1])
    others = [Clip(name, seed) for seed in range(8)]
    assert len({clip.duration for clip in others}) == len(others)


def test_names_seeds_and_refusals() -> None:
    raised = {int(np.argmax(Clip("wave", seed).angles(3.0)[:, 1])) for seed in range(10)}
    assert raised == {0, 1}
    medley, start = Clip("medley", 4), 0.0
    for name in CLIP_NAMES[:-1]:
        clip = Clip(name, 4)
        for part in (0.1, 0.45, 0.9):
            assert_allclose(
                medley.angles(start + part * clip.duration), clip.angles(part * clip.duration), atol=1e-9
            )
        start += clip.duration
    assert_allclose(medley.duration, start)
    with pytest.raises(BadSetting, match="choose from wave, clap, cross, reach, medley"):
        Clip("dance")  # type: ignore[arg-type]
    clip = Clip("clap", 1)
    clip.angles(0.0)[:] = 9.0
    clip.angles(clip.duration)[:] = 9.0
    assert_allclose(clip.angles(0.0), REST)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_motion_matches_the_clip_s_name(seed: int) -> None:
    def wrists(clip: Clip) -> np.ndarray:
        times = np.arange(0.0, clip.duration, 0.02)
        return np.array(
            [[arm_points(clip.angles(t)[i], s)[2] for i, s in enumerate(("left", "right"))] for t in times]
        )

    wave, clap, cross, reach = (wrists(Clip(name, seed)) for name in CLIP_NAMES[:4])
    assert np.linalg.norm(clap[:, 0] - clap[:, 1], axis=1).min() < 0.12
    assert (cross[:, 0, 1] - cross[:, 1, 1]).min() < -0.02
    assert wave[:, :, 2].max() > 0.1
    assert reach[:, :, 0].max() > 0.5


TIMES = np.array([0.0, 1.0, 3.0, 4.0])
TABLE = np.arange(4.0)[:, None, None] * np.ones((4, 2, 4))


def value(source: PersonSource, time: float) -> float | None:
    angles = source.angles(time)
    return None if angles is None else float(angles[1, 2])


def test_sampled_angles() -> None:
    sampled = SampledAngles(TIMES, TABLE)
    assert sampled.duration == 4.0
    times = (-1.0, 0.0, 0.5, 1.0, 2.0, 3.0, 3.25, 4.0, 99.0)
    assert [value(sampled, t) for t in times] == [0.0, 0.0, 0.5, 1.0, 1.5, 2.0, 2.25, 3.0, 3.0]
    # No person at a sample with NaN, nor between it and its neighbours.
    table = TABLE.copy()
    table[2, 0, 0] = np.nan
    sampled = SampledAngles(TIMES, table)
    assert [value(sampled, t) for t in (1.0, 1.1, 3.0, 3.9, 4.0)] == [1.0, None, None, None, 3.0]
    sampled = SampledAngles(np.array([2.0]), TABLE[1:2])
    assert [value(sampled, t) for t in (0.0, 2.0, 5.0)] == [1.0, 1.0, 1.0]
    sampled = SampledAngles(TIMES, TABLE.copy())
    angles = sampled.angles(1.0)
    assert angles is not None and angles.shape == (2, 4)
    angles[:] = 7.0
    assert value(sampled, 1.0) == 1.0


def test_shapes_and_times_are_checked() -> None:
    misfits = [(TIMES[:3], TABLE), (TIMES[:0], TABLE[:0]), (TIMES, TABLE[:, 0]), (TIMES[::-1], TABLE)]
    misfits += [(np.array([0.0, 1.0, wrong, 2.0]), TABLE) for wrong in (1.0, np.nan)]
    for times, table in misfits:
        with pytest.raises(ValueError, match="times"):
            SampledAngles(times, table)
