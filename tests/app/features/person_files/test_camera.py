"""Pose landmarks to angles, the camera's thread, and the opening of cameras, videos and models."""

import importlib
import math
import threading
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from numpy.testing import assert_allclose

from app.features.person_files import camera, film
from app.features.person_files.camera import (
    ARMS,
    ELBOWS,
    HIPS,
    SHOULDERS,
    WRISTS,
    CameraSource,
    landmarks_to_angles,
    read_film,
)
from app.features.person_files.film import VideoFrame
from controllers.errors import BadInputFile, BadSetting, DuetError
from controllers.kinematics import Array
from scenes.person.angles import arm_points
from scenes.person.clips import Clip
from scenes.person.source import MissingPackage
from tests.app.runtime.processes import until
from tests.scenes.person.strategies import SIDES, bodies, plain_arms

PATIENCE = 20.0
CAMERA_FROM_TORSO = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])
"""Person facing the camera: their left is right in the picture, up is −y, forward is −z."""


def landmarks_of(angles: Array) -> Array:
    """World landmarks (33, 3) of a person facing the camera, origin between the hips; the rest is noise."""
    table = np.random.default_rng(0).normal(0.0, 0.3, (33, 3))
    for i, side in enumerate(SIDES):
        chain = np.array(arm_points(angles[i], side)) + np.array([0.0, 0.0, 0.5])
        table[[SHOULDERS[i], ELBOWS[i], WRISTS[i]]] = chain @ CAMERA_FROM_TORSO.T
        table[HIPS[i]] = CAMERA_FROM_TORSO @ [0.0, 0.1 - 0.2 * i, 0.0]
    return table


SEEN = np.ones(33)


@given(bodies(plain_arms))
def test_landmarks_to_angles_also_without_hips(angles: Array) -> None:
    # Left and right are not exchanged for a person in front of the camera.
    found = landmarks_to_angles(landmarks_of(angles), SEEN)
    assert found is not None
    assert_allclose(found, angles, atol=1e-6)
    # Unseen or non-finite hips are assumed below the shoulders.
    table, visibility = landmarks_of(angles), SEEN.copy()
    visibility[list(HIPS)] = 0.1
    table[list(HIPS)] = np.nan
    found = landmarks_to_angles(table, visibility)
    assert found is not None
    assert_allclose(found, angles, atol=1e-6)


@pytest.mark.parametrize("landmark", ARMS)
def test_lost(landmark: int) -> None:
    good = landmarks_of(Clip("wave", 1).angles(1.0))
    assert landmarks_to_angles(good, SEEN) is not None
    hidden = SEEN.copy()
    hidden[landmark] = 0.49
    assert landmarks_to_angles(good, hidden) is None
    hidden[landmark] = np.nan
    assert landmarks_to_angles(good, hidden) is None
    for nonsense in (np.nan, np.inf):
        bad = good.copy()
        bad[landmark, 1] = nonsense
        assert landmarks_to_angles(bad, SEEN) is None
    folded = good.copy()
    folded[landmark] = folded[landmark - 2 if landmark > SHOULDERS[1] else landmark + 2] + 0.01
    assert landmarks_to_angles(folded, SEEN) is None


def test_a_noisy_sequence_with_drop_outs() -> None:
    random, clip, previous, errors, lost = np.random.default_rng(5), Clip("medley", 2), None, [], 0
    for t in np.arange(0.0, clip.duration, 1.0 / 30.0):
        visibility = np.where(random.uniform(size=33) < 0.01, 0.2, 0.9)
        found = landmarks_to_angles(
            landmarks_of(clip.angles(t)) + random.normal(0.0, 0.01, (33, 3)), visibility, previous
        )
        if found is None:
            lost += 1
            continue
        previous = found
        errors.append(np.abs(found - clip.angles(t)).max())
    assert 5 < lost < 300
    assert np.median(errors) < math.radians(12.0) and max(errors) < math.radians(75.0)


class Reel:
    def __init__(self, count: int, live: bool = True, rate: float = 1000.0, fault: int = -1) -> None:
        self.live, self.count, self.rate, self.fault = live, count, rate, fault
        self.at, self.closed = 0, threading.Event()
        self.gate = threading.Semaphore(0)

    def next(self) -> VideoFrame | None:
        if self.live and not self.gate.acquire(timeout=PATIENCE):
            return None
        if self.at == self.fault:
            raise RuntimeError("the cable was pulled\nfar away")
        if self.at >= self.count:
            return None
        self.at += 1
        return VideoFrame((self.at - 1) / self.rate, np.full((2, 2, 3), self.at - 1, np.uint8))

    def close(self) -> None:
        self.closed.set()


class Eye:
    def __init__(self, *blind: int) -> None:
        self.blind, self.closed = blind, False

    def find(self, picture: VideoFrame) -> tuple[Array, Array] | None:
        number = int(picture.image[0, 0, 0])
        return None if number in self.blind else (landmarks_of(Clip("wave", 1).angles(0.1 * number)), SEEN)

    def close(self) -> None:
        self.closed = True


def near(found: Array | None, picture: int) -> bool:
    return found is not None and bool(np.abs(found - Clip("wave", 1).angles(0.1 * picture)).max() < 1e-6)


def test_the_newest_picture_counts() -> None:
    now, reel, eye = [0.0], Reel(200), Eye(40)
    source = CameraSource(reel, eye, clock=lambda: now[0]).start()
    try:
        assert source.angles(0.0) is None and "No person is seen" in source.message
        reel.gate.release(31)
        until(lambda: near(source.angles(0.0), 30))
        assert near(source.angles(1e9), 30) and source.message == ""
        kept = source.angles(0.0)
        assert kept is not None
        kept[:] = 9.0
        assert near(source.angles(0.0), 30)
        reel.gate.release(10)
        until(lambda: source.angles(0.0) is None)
        reel.gate.release()
        until(lambda: near(source.angles(0.0), 41))
        now[0] += camera.STALE + 0.01
        assert source.angles(0.0) is None and "No person is seen" in source.message
        reel.count = 0
        reel.gate.release()
        until(lambda: not source.running)
        assert "no more pictures" in source.message
    finally:
        source.stop()
    assert reel.closed.is_set()
    assert eye.closed
    assert source.angles(0.0) is None


def test_threads_start_stop_and_fail() -> None:
    source = CameraSource(Reel(0), Eye())
    source.stop()
    assert source.message == "The camera is off."
    reel = Reel(5)
    source = CameraSource(reel, Eye()).start()
    reel.gate.release()
    source.stop(0.0)
    reel.gate.release()
    source.stop()
    source.stop()
    assert reel.closed.is_set()
    reel = Reel(5, fault=2)
    source = CameraSource(reel, Eye()).start()
    reel.gate.release(3)
    until(lambda: not source.running)
    assert "the cable was pulled" in source.message
    assert source.angles(0.0) is None
    assert reel.closed.is_set()


def test_films_are_played_in_real_time_or_read() -> None:
    # A film from a file is not read ahead of time, and its end is reported.
    reel = Reel(50, live=False, rate=500.0)
    source = CameraSource(reel, Eye()).start()
    until(lambda: not source.running)
    assert source.message == "The video has ended."
    assert reel.at == 50
    source = CameraSource(Reel(2, live=False, rate=1e-3), Eye()).start()
    until(lambda: near(source.angles(0.0), 0))
    source.stop()
    assert not source.running
    # The same film gives the same angles at its times, and none where no person is seen.
    tables = [read_film(Reel(20, live=False, rate=10.0), Eye(7)) for _ in range(2)]
    assert_allclose(tables[0].table, tables[1].table, atol=0.0)
    for k in range(20):
        assert near(tables[0].angles(k / 10.0), k) == (k != 7)
    assert tables[0].angles(0.7) is None
    for empty in (Reel(3, live=False), Reel(0, live=False)):
        with pytest.raises(BadInputFile, match="No person is seen"):
            read_film(empty, Eye(0, 1, 2))
    long = Reel(3, live=False, rate=1e-3)
    with pytest.raises(BadInputFile, match="longer than 30 minutes"):
        read_film(long, Eye())
    assert long.closed.is_set()


def test_missing_packages_or_files_are_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:

    def missing(name: str) -> None:
        raise ModuleNotFoundError(f"No module named {name!r}")

    monkeypatch.setattr(importlib, "import_module", missing)
    (there := tmp_path / "file").write_bytes(b"x")
    for attempt in (
        lambda: film.open_camera(0),
        lambda: film.open_video(there),
        lambda: film.open_detector(there),
    ):
        with pytest.raises(MissingPackage, match=r"lwr-duet\[camera\]") as caught:
            attempt()
        assert isinstance(caught.value, DuetError)
    # Missing files are reported before missing packages.
    for attempt in (film.open_video, film.open_detector):
        for path in (tmp_path / "none.mp4", tmp_path):
            with pytest.raises(BadInputFile, match="there is no such file"):
                attempt(path)


def test_a_missing_camera_is_named() -> None:
    pytest.importorskip("cv2")
    for index in (-1, 1000, 97):
        with pytest.raises(BadSetting, match=f"Camera {index}"):
            film.open_camera(index)


def test_a_real_video(tmp_path: Path) -> None:
    cv2 = pytest.importorskip("cv2")
    path = tmp_path / "red.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 20.0, (64, 48))
    for _ in range(6):
        writer.write(np.full((48, 64, 3), (10, 20, 200), np.uint8))
    writer.release()
    reel = film.open_video(path)
    assert not reel.live
    pictures = list(iter(reel.next, None))
    reel.close()
    assert_allclose([p.time for p in pictures], np.arange(6) / 20.0)
    assert_allclose(pictures[0].image.mean(axis=(0, 1)), [200, 20, 10], atol=12)
    noise = tmp_path / "noise.avi"
    noise.write_bytes(bytes(range(256)) * 20)
    with pytest.raises(BadInputFile, match="not a video"):
        film.open_video(noise)


def test_a_file_that_is_not_a_model_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("mediapipe")
    model = tmp_path / "pose.task"
    model.write_bytes(b"no model")
    with pytest.raises(BadInputFile, match="MediaPipe cannot use it"):
        film.open_detector(model)
