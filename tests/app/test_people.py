"""Input sources beside the built-in person: a BVH file, a camera, a law file; named when the server starts."""

import json
from pathlib import Path

import numpy as np
import pytest

from app.cli.main import main
from app.session.input_sources import InputSources, find_input_sources, from_bvh
from app.settings import Settings
from controllers.errors import BadInputFile, BadSetting
from scenes.person.bvh import read_bvh
from scenes.person.clips import Clip
from scenes.targets import AnglesTarget
from tests.app.conftest import Arrive, OpenHouse
from tests.scenes.person.bvh_text import MIXAMO, write_bvh


@pytest.fixture
def wave(tmp_path: Path) -> Path:
    path = tmp_path / "wave.bvh"
    path.write_text(write_bvh(Clip("wave"), MIXAMO), encoding="utf-8")
    return path


def angles_of(target: object) -> np.ndarray:
    assert isinstance(target, AnglesTarget) and target.angles is not None
    return target.angles


def test_a_recorded_person_starts_again_at_the_end(wave: Path) -> None:
    motion = read_bvh(wave)
    person = from_bvh(motion)
    for time in (0.0, 0.7, 0.5 * motion.duration):
        for laps in (0, 3):
            wanted = motion.angles(time)
            assert wanted is not None
            assert np.abs(angles_of(person.target(time + laps * motion.duration)) - wanted).max() < 1e-9


def test_wrong_sources_are_refused(wave: Path, tmp_path: Path) -> None:
    with pytest.raises(BadSetting, match="one of them"):
        find_input_sources(None, 0, wave, wave)
    with pytest.raises(BadSetting, match="--pose-model"):
        find_input_sources(None, 0, None, None)
    broken = tmp_path / "broken.bvh"
    broken.write_text("HIERARCHY\nROOT", encoding="utf-8")
    with pytest.raises(BadInputFile, match=r"broken\.bvh"):
        find_input_sources(broken, None, None, None)
    assert find_input_sources(None, None, None, None) == InputSources()


def test_run_imitates_a_file(wave: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, bvh = tmp_path / "out.csv", ["--bvh", str(wave)]
    last: list[str] = []
    for options in (bvh, ["--clip", "clap"]):
        assert main(["run", "--scene", "imitation", "--seconds", "3", "--csv", str(out), *options]) == 0
        assert json.loads(capsys.readouterr().out)["steps"] == 600
        last.append(out.read_text(encoding="utf-8").splitlines()[-1])
    assert last[0] != last[1]
    for wrong, named in (bvh, "--scene imitation"), (["--scene", "imitation", *bvh, "--inputs", str(wave)], "one of them"):
        assert main(["run", "--seconds", "1", *wrong]) == 2
        assert named in capsys.readouterr().err


def test_a_visitor_chooses_a_file_then_a_camera_that_is_not_there_then_the_clips(
    house: OpenHouse, arrive: Arrive, wave: Path
) -> None:
    guest = arrive(house(Settings(), sources=find_input_sources(wave, None, None, None)))
    session, motion = guest.session, read_bvh(wave)
    guest.ask(lambda s: [s.change("source", "file"), s.change("scene", "imitation")])
    guest.run_on(0.3)
    guest.ask(lambda s: s.toggle_pause())
    shown = angles_of(session.target())
    seen = [motion.angles(t) for t in np.linspace(0.0, motion.duration, 600)]
    assert min(np.abs(shown - angles).max() for angles in seen if angles is not None) < 0.02
    for source in ("camera", "clips"):
        guest.ask(lambda s, source=source: s.change("source", source))
    clip = Clip(session.settings.run.clip, session.settings.run.seed)
    guest.visitor.wait_for(lambda _: session.target() is not None)
    shown = angles_of(session.target())
    assert min(np.abs(shown - clip.angles(t)).max() for t in np.arange(0.0, 5.0, 0.005)) < 0.02
