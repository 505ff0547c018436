"""MJCF that MuJoCo loads: poses, masses, contacts that leave a scene at rest, and cameras."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from glassware.dataset.exports.run import export
from glassware.dataset.exports.scenes.mjcf import write_mjcf
from glassware.dataset.reader import Dataset
from glassware.procedural.description.camera import Camera

#: How far a body of a scene at rest may move in half a second [m]: twice the gap of contacts and what they give way.
STILL = 5e-4


@pytest.fixture(scope="module")
def made(proven, tmp_path_factory):
    """The stored scene, its records, and MuJoCo's model of the export."""
    folder = tmp_path_factory.mktemp("mjcf")
    export(proven, "mjcf", folder / "out")
    scene = Dataset.open(proven).scenes[0]
    return scene.scene(), scene.objects().objects, load(folder / "out" / "000000")


def load(folder):
    model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def body(model, name):
    return model.body(name.replace("-", "_")).id


def pose(data, number):
    found = np.eye(4)
    found[:3, :3], found[:3, 3] = data.xmat[number].reshape(3, 3), data.xpos[number]
    return found


def test_bodies_are_where_they_are_with_their_mass_and_inertia(made):
    scene, records, (model, data) = made
    assert model.nbody == 1 + len(scene.objects)
    for item, record in zip(scene.objects, records, strict=True):
        number = body(model, item.name)
        np.testing.assert_allclose(pose(data, number), item.world_T_object, atol=1e-6)
        whole = record.mechanics.whole
        assert model.body_mass[number] == pytest.approx(whole.mass, rel=1e-9)
        np.testing.assert_allclose(model.body_ipos[number], whole.centre_of_mass, atol=1e-9)
        turn = np.empty(9)
        mujoco.mju_quat2Mat(turn, model.body_iquat[number])
        turn = turn.reshape(3, 3)
        inertia = turn @ np.diag(model.body_inertia[number]) @ turn.T
        np.testing.assert_allclose(inertia, whole.inertia, atol=1e-9 + 1e-6 * np.trace(whole.inertia))
        geometry = model.geom_friction[model.geom_bodyid == number][:, 0]
        assert record.mechanics.friction in geometry


def test_meshes_are_those_of_the_scene(made):
    scene, _, (model, _) = made
    for item in scene.props:
        (shown,) = [model.mesh(name) for name in names(model) if name.startswith(f"{item.name.replace('-', '_')}-0")]
        first = item.pieces[0].faces
        assert model.mesh_facenum[shown.id] == first


def names(model):
    return [model.mesh(number).name for number in range(model.nmesh)]


def test_a_scene_at_rest_stays_at_rest(made):
    _, _, (model, _) = made
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    before = data.xpos.copy()
    for _ in range(int(0.5 / model.opt.timestep)):
        mujoco.mj_step(model, data)
    assert np.linalg.norm(data.xpos - before, axis=1).max() < STILL


def test_what_goes_with_a_vessel_moves_with_it(made, tmp_path):
    scene, records, _ = made
    vessel, prop = scene.vessels[0], scene.props[0]
    changed = scene.model_copy(update={"props": (prop.model_copy(update={"part_of": vessel.name}),)})
    write_mjcf(tmp_path, changed, records, [vessel.id, prop.id])
    model, data = load(tmp_path)
    assert model.body_parentid[body(model, prop.name)] == body(model, vessel.name)
    assert model.njnt == 1
    np.testing.assert_allclose(pose(data, body(model, prop.name)), prop.world_T_object, atol=1e-6)


def test_cameras_have_the_lens_of_the_views_even_off_the_middle(made, tmp_path):
    scene, records, _ = made
    lens = scene.cameras[0].model_dump(include={"focal", "world_T_camera", "baseline", "exposure", "grid_index"})
    camera = Camera(**lens, width=64, height=48, centre=(20.0, 30.5))
    write_mjcf(tmp_path, scene.model_copy(update={"cameras": (camera,)}), records, [])
    model, data = load(tmp_path)
    turned = data.cam_xmat[0].reshape(3, 3) @ np.diag([1.0, -1.0, -1.0])
    np.testing.assert_allclose(turned, np.array(camera.world_T_camera)[:3, :3], atol=1e-6)
    np.testing.assert_allclose(data.cam_xpos[0], np.array(camera.world_T_camera)[:3, 3], atol=1e-6)
    shown = mujoco.MjvScene(model, 1000)
    chosen = mujoco.MjvCamera()
    chosen.type, chosen.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, 0
    mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, chosen, mujoco.mjtCatBit.mjCAT_ALL, shown)
    seen = shown.camera[0]  # slopes of the frustum's sides, by which a renderer draws
    (cx, cy), near = camera.centre, seen.frustum_near
    sides = np.array([seen.frustum_center - seen.frustum_width, seen.frustum_center + seen.frustum_width]) / near
    np.testing.assert_allclose(sides, [-(cx + 0.5) / camera.fx, (63.5 - cx) / camera.fx], atol=1e-6)
    ends = np.array([seen.frustum_top, seen.frustum_bottom]) / near
    np.testing.assert_allclose(ends, [(cy + 0.5) / camera.fy, -(47.5 - cy) / camera.fy], atol=1e-6)
