"""``camera.json`` and ``objects.json``."""

from __future__ import annotations

import numpy as np

from glassware.annotate.keypoints import scene_keypoints
from glassware.dataset.format.camera_file import CameraFile, camera_file, camera_of
from glassware.dataset.format.objects_file import ObjectsFile, objects_file
from glassware.procedural.optics.medium import Medium
from glassware.procedural.primitives import bodies


def test_a_camera_comes_back_from_its_record_exactly(analytic):
    camera = analytic.camera(1)
    record = CameraFile.model_validate_json(camera_file(camera).model_dump_json())
    assert camera_of(record).model_dump_json() == camera.model_dump_json()


def test_a_camera_of_two_focal_lengths_off_the_grid_comes_back_as_well(analytic):
    camera = analytic.camera(1).model_copy(update={"focal_y": 150.0, "grid_index": None})
    record = CameraFile.model_validate_json(camera_file(camera).model_dump_json())
    assert record.K is not None
    assert (record.K[0][0], record.K[1][1]) == (camera.focal, 150.0)
    assert camera_of(record).model_dump_json() == camera.model_dump_json()


def test_a_camera_record_says_its_conventions_and_both_poses(analytic):
    camera = analytic.camera(0)
    record = camera_file(camera)
    assert record.K is not None
    assert record.world_T_right is not None
    assert record.K[0] == (camera.focal, 0.0, camera.centre[0])
    assert record.distortion == "none"
    assert "(0, 0) has its centre at image coordinate (0, 0)" in record.conventions["pixels"]
    step = record.world_T_right[:3, 3] - record.world_T_camera[:3, 3]
    np.testing.assert_allclose(step, camera.baseline * record.world_T_camera[:3, 0], atol=1e-15)


def test_objects_have_materials_parts_symmetries_and_keypoints(analytic):
    scene = analytic.scene()
    # The vessel has normals and rings, as liquids need them.
    silica = scene.vessels[0].glass
    profile = [(analytic.RADIUS, 0.0), (analytic.RADIUS, analytic.HEIGHT)]
    tea = Medium(name="tea", eta=1.333, sigma_a=(1, 4, 9), density=998.0, surface_tension=0.0728, contact_angle=0.4)
    glass = bodies.vessel(profile, silica, liquid=tea, fill=0.6, name="glass", chord_error=2e-4)
    scene = scene.model_copy(update={"vessels": (glass,)})
    points = scene_keypoints(scene)
    records = ObjectsFile.model_validate_json(objects_file(scene, points).model_dump_json()).objects
    assert [record.id for record in records] == [2, 3, 4]
    vessel, ball, block = records
    assert [(part.id, part.name) for part in vessel.parts] == [(1, "glass"), (2, "liquid")]
    assert vessel.material.kind == "glass"
    assert vessel.material.medium == glass.glass
    assert vessel.liquid is not None
    assert vessel.liquid == glass.liquid
    assert vessel.liquid.medium == tea
    assert ball.liquid is None
    assert ball.material.kind == "opaque"
    assert ball.material.name == "clay"
    assert [len(record.symmetries_continuous) for record in records] == [1, 2, 0]
    # A block of three different sides has three half turns.
    assert [len(record.symmetries_discrete) for record in records] == [0, 0, 3]
    for motion in block.symmetries_discrete:
        np.testing.assert_allclose(np.abs(motion), np.eye(4), atol=1e-12)
    assert vessel.symmetries_continuous[0].axis == (0.0, 0.0, 1.0)
    np.testing.assert_array_equal(block.keypoints, points.local[2])
    np.testing.assert_array_equal(block.world_T_object, scene.objects[2].world_T_object)
