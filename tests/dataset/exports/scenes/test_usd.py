"""USD read by OpenUSD's own library, and as text where that is not installed."""

from __future__ import annotations

import re

import numpy as np
import pytest

from glassware.dataset.exports.run import export
from glassware.dataset.exports.scenes.usd import write_usd
from glassware.dataset.reader import Dataset
from glassware.procedural.description.camera import Camera
from glassware.procedural.description.scene import glass_solid


@pytest.fixture(scope="module")
def made(proven, tmp_path_factory):
    folder = tmp_path_factory.mktemp("usd")
    export(proven, "usd", folder / "out")
    scene = Dataset.open(proven).scenes[0]
    return scene.scene(), scene.objects().objects, folder / "out" / "000000.usda"


def test_the_text_has_each_object_with_its_pose_and_mass(made):
    scene, records, path = made
    text = path.read_text()
    assert text.count("{") == text.count("}")
    for item, record in zip(scene.objects, records, strict=True):
        body = text.split(f'def Xform "{item.name.replace("-", "_")}"', 1)[1]
        numbers = re.search(r"xformOp:transform = \(\((.*?)\)\)", body)
        assert numbers is not None
        matrix = np.reshape([float(x) for x in re.findall(r"[-\d.e]+", numbers[1])], (4, 4)).T
        np.testing.assert_allclose(matrix, item.world_T_object, atol=1e-6)
        mass = re.search(r"physics:mass = ([-\d.e]+)", body)
        assert mass is not None
        assert float(mass[1]) == record.mechanics.whole.mass


def test_openusd_reads_poses_meshes_and_physics(made):
    pytest.importorskip("pxr")
    from pxr import Usd, UsdGeom, UsdPhysics  # pyright: ignore[reportMissingImports]

    scene, records, path = made
    stage = Usd.Stage.Open(str(path))
    assert (UsdGeom.GetStageUpAxis(stage), UsdGeom.GetStageMetersPerUnit(stage)) == ("Z", 1.0)
    cache = UsdGeom.XformCache()
    for item, record in zip(scene.objects, records, strict=True):
        prim = stage.GetPrimAtPath(f"/world/{item.name.replace('-', '_')}")
        assert prim.HasAPI(UsdPhysics.RigidBodyAPI)
        pose = np.array(cache.GetLocalToWorldTransform(prim)).T
        np.testing.assert_allclose(pose, item.world_T_object, atol=1e-6)
        mass, whole = UsdPhysics.MassAPI(prim), record.mechanics.whole
        assert mass.GetMassAttr().Get() == pytest.approx(whole.mass, rel=1e-6)
        np.testing.assert_allclose(mass.GetCenterOfMassAttr().Get(), whole.centre_of_mass, atol=1e-6)
        axes = mass.GetPrincipalAxesAttr().Get()
        turn = rotation(axes.GetReal(), *axes.GetImaginary())
        inertia = turn @ np.diag(mass.GetDiagonalInertiaAttr().Get()) @ turn.T
        np.testing.assert_allclose(inertia, whole.inertia, atol=1e-5 * np.trace(whole.inertia))
        touching = [UsdGeom.Mesh(child) for child in Usd.PrimRange(prim) if child.HasAPI(UsdPhysics.CollisionAPI)]
        assert touching
        assert all(len(mesh.GetPointsAttr().Get()) >= 4 for mesh in touching)
    vessel = scene.vessels[0]
    name = vessel.name.replace("-", "_")
    glass = UsdGeom.Mesh(stage.GetPrimAtPath(f"/world/{name}/{name}_glass"))
    np.testing.assert_array_equal(np.array(glass.GetPointsAttr().Get(), np.float32), glass_solid(vessel).vertices)
    np.testing.assert_array_equal(glass.GetFaceVertexIndicesAttr().Get(), glass_solid(vessel).faces.ravel())


def rotation(w, x, y, z):
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def test_openusd_projects_points_as_our_cameras_do(made, tmp_path):
    pytest.importorskip("pxr")
    from pxr import Usd, UsdGeom  # pyright: ignore[reportMissingImports]

    scene, records, _ = made
    lens = scene.cameras[0].model_dump(include={"focal", "world_T_camera", "baseline", "exposure", "grid_index"})
    camera = Camera(**lens, width=64, height=48, centre=(20.0, 30.5))
    write_usd(tmp_path / "one.usda", scene.model_copy(update={"cameras": (camera,)}), records, [])
    stage = Usd.Stage.Open(str(tmp_path / "one.usda"))
    frustum = UsdGeom.Camera(stage.GetPrimAtPath("/world/view_000")).GetCamera(0.0).frustum
    point = np.array([0.03, -0.02, 0.1, 1.0])
    x, y, _, w = point @ np.array(frustum.ComputeViewMatrix() * frustum.ComputeProjectionMatrix())
    u, v = (x / w + 1.0) / 2.0 * 64 - 0.5, (1.0 - y / w) / 2.0 * 48 - 0.5
    seen = camera.K @ (np.linalg.inv(camera.world_T_camera) @ point)[:3]
    np.testing.assert_allclose([u, v], seen[:2] / seen[2], atol=1e-3)  # lenses are float32 in USD
