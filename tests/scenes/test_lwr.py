"""The generated URDF matches the facts; `robots/test_files.py` compares two readers of it."""

import io

import numpy as np
import pinocchio as pin
import pytest
import yourdfpy
from numpy.testing import assert_allclose

from scenes.lwr import facts
from scenes.lwr.urdf import FLANGE, URDF_FILE, link_inertia, lwr_urdf
from tests.scenes.robots.helpers import other_reader


@pytest.fixture(scope="module")
def model() -> pin.Model:
    return pin.buildModelFromXML(lwr_urdf())


def flange_pose(model: pin.Model, q: np.ndarray) -> np.ndarray:
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    return data.oMf[model.getFrameId(FLANGE)].homogeneous


def test_the_shipped_file_is_the_generated_one() -> None:
    assert URDF_FILE.read_text(encoding="utf-8") == lwr_urdf()


def test_the_chain_and_its_masses(model: pin.Model) -> None:
    assert list(model.names)[1:] == [joint.name for joint in facts.JOINTS]
    # The robot's standard DH table gives the same flange as the joint origins.
    table = zip((90, -90, -90, 90, 90, -90, 0), (0.310, 0, 0.400, 0, 0.390, 0, 0.078), strict=True)
    rows = [(np.radians(alpha), d) for alpha, d in table]
    for q in np.random.default_rng(8).uniform(-2, 2, (20, 7)):
        pose = np.eye(4)
        for (alpha, d), angle in zip(rows, q, strict=True):
            step = pin.SE3(pin.utils.rotate("z", angle) @ pin.utils.rotate("x", alpha), np.array([0, 0, d]))
            pose = pose @ step.homogeneous
        assert_allclose(flange_pose(model, q), pose, atol=1e-12)
    assert_allclose(np.degrees(model.upperPositionLimit), [170, 120, 170, 120, 170, 120, 170])
    assert_allclose(model.lowerPositionLimit, -model.upperPositionLimit)
    assert_allclose(np.degrees(model.velocityLimit), [100, 110, 100, 130, 130, 180, 180])
    assert_allclose(model.effortLimit, [176, 176, 100, 100, 100, 38, 38])
    assert_allclose([inertia.mass for inertia in list(model.inertias)[1:]], facts.MASSES[1:])
    assert_allclose([inertia.lever for inertia in list(model.inertias)[1:]], facts.CENTRES_OF_MASS[1:])
    assert pin.computeTotalMass(model) == pytest.approx(sum(facts.MASSES[1:]))
    assert sum(facts.MASSES) == pytest.approx(13.6, abs=0.05)
    data = model.createData()
    for q in np.random.default_rng(9).uniform(model.lowerPositionLimit, model.upperPositionLimit, (20, 7)):
        assert np.linalg.eigvalsh(pin.crba(model, data, q) + 0)[0] > 0
    text = lwr_urdf()
    assert "<capsule" not in text and "<mesh" not in text
    visual = pin.buildGeomFromUrdfString(model, text, pin.GeometryType.VISUAL)
    collision = pin.buildGeomFromUrdfString(model, text, pin.GeometryType.COLLISION)
    assert len(visual.geometryObjects) >= 8
    assert len(collision.geometryObjects) == 3 * len(facts.CAPSULES)
    with_meshes = yourdfpy.URDF.load(io.StringIO(text), build_scene_graph=True, load_meshes=True)
    assert len(with_meshes.scene.geometry) == len(visual.geometryObjects)


def test_inertias_belong_to_real_bodies() -> None:
    other = other_reader("lwr")
    for link in range(8):
        tensor = other.link_map[f"link{link}"].inertial.inertia
        assert_allclose(tensor, tensor.T)
        assert_allclose(np.diag(tensor), link_inertia(link), rtol=1e-9)
        moments = np.sort(np.linalg.eigvalsh(tensor))
        assert moments[0] > 0 and moments[2] <= moments[0] + moments[1]
