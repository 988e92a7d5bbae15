"""The film of a push."""

import io

import numpy as np
import pytest
from PIL import Image

from app.features.duel.push_film import BEFORE, SECONDS, film_bytes
from scenes.inputs import Recorded
from scenes.targets import HandTarget
from tests.scenes.inputs.test_run_text import recorded as run_of


def there_and_back(seconds: float, dt: float = 0.02) -> Recorded:
    """The hand approaches the other hand and returns."""
    turn = 0.4 * seconds
    return run_of(
        lambda s, i: HandTarget(np.array([0.25 - 0.25 * max(0.0, 1.0 - abs(i * dt - turn)), 0.0, 1.3]), None),
        round(seconds / dt),
        dt,
    )


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.parametrize("seconds", [2.0, 8.0])
def test_a_film_has_five_seconds_around_the_nearest_moment(seconds: float) -> None:
    film = film_bytes(there_and_back(seconds), size=(64, 48), rate=2.0)
    with Image.open(io.BytesIO(film)) as picture:
        assert picture.format == "WEBP" and picture.size == (64, 48)
        lengths, seen = [], set()
        for frame in range(getattr(picture, "n_frames", 0)):
            picture.seek(frame)
            seen.add(picture.convert("RGB").tobytes())
            lengths.append(picture.info["duration"])
    assert sum(lengths) == 1000.0 * SECONDS and len(seen) > 2, "the picture moves"
    assert (max(lengths) > 2000) == (seconds < BEFORE), "a short push holds its last frame"
