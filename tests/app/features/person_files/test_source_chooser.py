"""The imitated person: from a file of the server or visitor, or from a camera."""

import json
import pickle
from pathlib import Path
from unittest.mock import MagicMock

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from app.__main__ import run_command as main
from app.features.person_files.bvh import from_bvh, read_bvh
from app.features.person_files.opened_persons import open_persons
from app.features.person_files.person_options import PersonOptions
from app.features.person_files.source_chooser import SourceChooser, TakePerson
from app.hosting.serve_options import ServeOptions
from app.page.panel_context import PanelContext
from app.runtime.terminal import INTERRUPTED
from app.session.action_handlers import ActionHandlers
from app.session.frame import freeze
from app.session.session import Session
from app.settings import PageSettings, Settings
from app.start import App
from controllers.errors import BadInputFile, BadSetting
from scenes.person.clips import Clip
from scenes.settings import RunSettings
from scenes.targets import AnglesTarget
from tests.app.conftest import Arrive, OpenHouse
from tests.app.features.person_files.bvh_text import MIXAMO, write_bvh
from tests.approved import Approve
from tests.browser import free_port


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
        open_persons(PersonOptions(camera=0, video=wave, pose_model=wave))
    with pytest.raises(BadSetting, match="--pose-model"):
        open_persons(PersonOptions(camera=0))
    broken = tmp_path / "broken.bvh"
    broken.write_text("HIERARCHY\nROOT", encoding="utf-8")
    with pytest.raises(BadInputFile, match=r"broken\.bvh"):
        open_persons(PersonOptions(bvh=broken))
    nothing = open_persons(PersonOptions())
    assert nothing.bvh is nothing.camera is None


def test_run_imitates_a_file(wave: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, bvh = tmp_path / "out.csv", ["--bvh", str(wave)]
    last: list[str] = []
    for options in (bvh, ["--clip", "clap"]):
        assert main(["run", "--scene", "imitation", "--seconds", "3", "--csv", str(out), *options]) == 0
        assert json.loads(capsys.readouterr().out)["steps"] == 600
        last.append(out.read_text(encoding="utf-8").splitlines()[-1])
    assert last[0] != last[1]
    for wrong, named in (
        (bvh, "--scene imitation"),
        (["--scene", "imitation", *bvh, "--inputs", str(wave)], "one of them"),
    ):
        assert main(["run", "--seconds", "1", *wrong]) == 2
        assert named in capsys.readouterr().err


def test_a_visitor_chooses_a_file_then_a_missing_camera_then_the_clips(
    house: OpenHouse, arrive: Arrive, wave: Path
) -> None:
    guest = arrive(house(features=(PersonOptions(bvh=wave),)))
    session, motion = guest.session, read_bvh(wave)
    guest.ask(lambda s: [s.change("source", "file"), s.change("scene", "imitation")])
    guest.run_on(0.3)
    guest.ask(lambda s: s.control.toggle_pause())
    shown = angles_of(session.target())
    seen = [motion.angles(t) for t in np.linspace(0.0, motion.duration, 600)]
    assert min(np.abs(shown - angles).max() for angles in seen if angles is not None) < 0.02
    for source in ("camera", "clips"):
        guest.ask(lambda s, source=source: s.change("source", source))
    clip = Clip(session.settings.run.clip, session.settings.run.seed)
    guest.visitor.wait_for(lambda _: session.target() is not None)
    shown = angles_of(session.target())
    assert min(np.abs(shown - clip.angles(t)).max() for t in np.arange(0.0, 5.0, 0.005)) < 0.02


def test_a_visitors_file_is_kept_when_the_page_is_rebuilt(wave: Path) -> None:
    session, content = (
        Session(Settings(RunSettings(scene="imitation"), PageSettings(source="file"))),
        wave.read_bytes(),
    )
    for brings in (True, False):
        client, handlers = MagicMock(), ActionHandlers()
        page = SourceChooser(
            PanelContext(client, session, MagicMock(), handlers, MagicMock(), MagicMock(), MagicMock(), True)
        )
        said = client.gui.add_html.return_value
        page.show(freeze(session, 0.0))
        if brings:
            assert "Choose a BVH file" in said.content
            handlers.do(TakePerson("wave.bvh", content))
        assert said.content == ""
        assert_array_equal(angles_of(session.target()), read_bvh(wave).angles(0.0))


def test_the_command_passes_all_sources_of_a_person_to_the_server(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    served: list[PersonOptions] = []

    def alone(options: ServeOptions, *_: object, **__: object) -> App:
        # Serialised as in the messages to a worker.
        served.append(pickle.loads(pickle.dumps(options)).of(PersonOptions))
        raise KeyboardInterrupt

    monkeypatch.setattr("app.start.start_app", alone)
    video, model, bvh = (tmp_path / name for name in ("video", "model", "bvh"))
    given = [
        "serve",
        "--store",
        "memory",
        "--port",
        str(free_port()),
        "--bvh",
        str(bvh),
        "--video",
        str(video),
    ]
    given += ["--pose-model", str(model), "--source", "camera"]
    # One process reads the camera, on any machine.
    assert main([*given, "--camera", "1"]) == INTERRUPTED
    assert served == [PersonOptions(bvh=bvh, camera=1, video=video, pose_model=model)]


@pytest.mark.parametrize("film", [("--camera", "0"), ("--video", "walk.mp4")])
def test_several_processes_cannot_read_one_camera(
    film: tuple[str, str], capsys: pytest.CaptureFixture[str], approve: Approve
) -> None:
    assert main(["serve", "--workers", "2", "--store", "memory", *film]) == 2
    approve("workers and a camera.txt", capsys.readouterr().err)
