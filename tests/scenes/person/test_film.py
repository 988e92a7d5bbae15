"""The ways into cameras, videos and models: real ones where this machine has them, and a clear word where not."""

import importlib
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from controllers.errors import BadInputFile, BadSetting, DuetError
from scenes.person import film
from scenes.person.source import MissingPackage


def test_without_the_packages(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:

    def missing(name: str) -> None:
        raise ModuleNotFoundError(f"No module named {name!r}")

    monkeypatch.setattr(importlib, "import_module", missing)
    (there := tmp_path / "file").write_bytes(b"x")
    for attempt in (lambda: film.open_camera(0), lambda: film.open_video(there), lambda: film.open_detector(there)):
        with pytest.raises(MissingPackage, match=r"pip install 'lwr-duet\[camera\]'") as caught:
            attempt()
        assert isinstance(caught.value, DuetError)


def test_missing_files(tmp_path: Path) -> None:
    for attempt in (film.open_video, film.open_detector):
        for path in (tmp_path / "none.mp4", tmp_path):
            with pytest.raises(BadInputFile, match="there is no such file"):
                attempt(path)


def test_no_camera() -> None:
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


def test_a_model_that_is_none(tmp_path: Path) -> None:
    pytest.importorskip("mediapipe")
    model = tmp_path / "pose.task"
    model.write_bytes(b"no model")
    with pytest.raises(BadInputFile, match="MediaPipe cannot use it"):
        film.open_detector(model)
