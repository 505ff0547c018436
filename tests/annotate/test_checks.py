"""Each check passes on the closed-form scene, and fails on each way of breaking what it guards."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from glassware.annotate import checks, geometry_checks
from glassware.annotate.keypoints import scene_keypoints
from glassware.annotate.labels import annotate
from glassware.annotate.masks import encode_mask


@pytest.fixture(scope="module")
def view(analytic):
    scene = analytic.scene()
    camera = scene.cameras[1]
    points = scene_keypoints(scene)
    geometry = analytic.geometry(scene, camera)
    labels = annotate(scene, camera, geometry, points, analytic.sight(scene, camera, points.world.reshape(-1, 3)))
    return scene, camera, labels, geometry, analytic.geometry(scene, camera, "right")


def test_no_check_finds_fault_with_any_view_of_the_closed_form_scene(analytic):
    scene = analytic.scene(views=4)
    points = scene_keypoints(scene)
    for camera in scene.cameras:
        geometry, right = (analytic.geometry(scene, camera, eye) for eye in ("left", "right"))
        labels = annotate(scene, camera, geometry, points, analytic.sight(scene, camera, points.world.reshape(-1, 3)))
        assert checks.check_view(scene, camera, labels, geometry, right) == []


def _changed(array, where, value):
    copy = array.copy()
    copy[where] = value
    return copy


def _one(mask):
    """The first pixel of a mask."""
    rows, columns = np.nonzero(mask)
    return rows[0], columns[0]


def _wrong_geometry(g, right):
    """Every way of breaking the geometry that a check of it alone must find: name of the check, broken geometry."""
    seen, hidden = g.id == 2, g.crossed[1] & (g.id == 2)
    table, nothing = g.id == 1, g.id == 0
    rows, columns = np.nonzero(g.id == 4)
    block = rows[len(rows) // 2], columns[len(rows) // 2]
    flat = g.normal.copy()
    flat[table] = flat[table] + np.array([0.3, 0.0, 0.0])
    flat[table] /= np.linalg.norm(flat[table], axis=-1, keepdims=True)
    return {
        "unknown id": ("ids", replace(g, id=_changed(g.id, block, 9))),
        "id without depth": ("ids", replace(g, Z=_changed(g.Z, _one(table), np.inf))),
        "id of nothing with depth": ("ids", replace(g, id=_changed(g.id, _one(table), 0))),
        "glass as background": ("ids", replace(g, background_id=_changed(g.background_id, _one(seen), 2))),
        "background id without depth": ("ids", replace(g, background_Z=_changed(g.background_Z, _one(table), np.inf))),
        "visible but not reached": ("ids", replace(g, reached=_changed(g.reached, (0, *_one(seen)), False))),
        "reached but not crossed": ("ids", replace(g, crossed=_changed(g.crossed, (1, *_one(hidden)), False))),
        "background in front": ("background", replace(g, background_Z=_changed(g.background_Z, _one(seen), 0.1))),
        "opaque that is not its own background": (
            "background",
            replace(g, background_Z=_changed(g.background_Z, _one(table), 5.0)),
        ),
        "transmittance above 1": ("background", replace(g, transmittance=_changed(g.transmittance, (3, 3, 1), 1.1))),
        "transmittance not a number": ("background", replace(g, transmittance=g.transmittance * np.nan)),
        "long normal": ("normals", replace(g, normal=_changed(g.normal, block, g.normal[block] * 1.001))),
        "normal that looks away": ("normals", replace(g, normal=_changed(g.normal, block, -g.normal[block]))),
        "normal of nothing": ("normals", replace(g, normal=_changed(g.normal, _one(nothing), [0, 0, -1]))),
        "no normal on a surface": ("normals", replace(g, normal=_changed(g.normal, block, [0, 0, 0]))),
        "normal turned by 17 degrees": ("normals against depth", replace(g, normal=flat.astype(np.float32))),
    }


NAMES = [
    "unknown id",
    "id without depth",
    "id of nothing with depth",
    "glass as background",
    "background id without depth",
    "visible but not reached",
    "reached but not crossed",
    "background in front",
    "opaque that is not its own background",
    "transmittance above 1",
    "transmittance not a number",
    "long normal",
    "normal that looks away",
    "normal of nothing",
    "no normal on a surface",
    "normal turned by 17 degrees",
]


@pytest.mark.parametrize("name", NAMES)
def test_a_fault_of_the_geometry_is_found(view, name):
    scene, camera, labels, geometry, right = view
    cases = _wrong_geometry(geometry, right)
    assert sorted(cases) == sorted(NAMES)
    check, broken = cases[name]
    found = checks.check_view(scene, camera, labels, broken)
    assert check in {violation.check for violation in found}
    assert all(violation.where and violation.expected and violation.found for violation in found)


@pytest.mark.parametrize("name", ["shift", "scale", "nearer left", "swapped"])
def test_a_pair_that_does_not_fit_is_found(view, analytic, name):
    _, camera, _, left, right = view
    broken = {
        "shift": (left, replace(right, Z=np.roll(right.Z, 3, axis=1), id=np.roll(right.id, 3, axis=1))),
        "scale": (left, replace(right, Z=right.Z * np.float32(1.02))),
        "nearer left": (replace(left, Z=left.Z * np.float32(0.98)), right),
        "swapped": (right, left),
    }[name]
    assert {v.check for v in geometry_checks.check_disparity(*broken, camera)} == {"disparity"}
    assert geometry_checks.check_disparity(left, right, camera) == []


def test_a_wrong_baseline_is_found(view):
    _, camera, _, left, right = view
    # Both sides of the equation take the baseline, so what shows is where points land: here by two pixels of ten.
    for factor in (0.8, 1.25):
        wrong = camera.model_copy(update={"baseline": camera.baseline * factor})
        assert geometry_checks.check_disparity(left, right, wrong)


def _label(labels, index, **update):
    objects = list(labels.objects)
    objects[index] = objects[index].model_copy(update=update)
    return labels.model_copy(update={"objects": tuple(objects)})


def _pixels(label, **update):
    return {"pixels": label.pixels.model_copy(update=update)}


def _wrong_labels(labels, geometry):
    glass, ball, block = labels.objects
    box, shares = glass.box2d, ball.fractions
    left, top, right, bottom = box.amodal
    turn = np.eye(4)
    turn[:2, :2] = [[0, -1], [1, 0]]
    moved = tuple((x + 0.01, y, z) for x, y, z in block.box3d)
    squeezed = (*block.box3d[:7], tuple(0.99 * value for value in block.box3d[7]))
    shrunk = tuple(tuple(0.8 * np.array(p) + 0.2 * np.array(block.centroid.point)) for p in block.box3d)
    mask = _changed(geometry.crossed[0], _one(geometry.crossed[0]), False)
    rle = glass.mask_amodal.model_copy(update={"counts": encode_mask(mask)})
    size = glass.mask_amodal.model_copy(update={"size": (10, 10)})
    away = (ball.keypoints[1].model_copy(update={"pixel": (2.0, 3.0)}), *ball.keypoints[1:])
    outside = (block.keypoints[0].model_copy(update={"state": "outside"}), *block.keypoints[1:])
    nowhere = (block.keypoints[0].model_copy(update={"pixel": None, "Z": -1.0}), *block.keypoints[1:])
    return {
        "swapped objects": ("objects", labels.model_copy(update={"objects": (ball, glass, block)})),
        "turned pose": ("poses", _label(labels, 2, camera_T_object=block.camera_T_object @ turn)),
        "moved box3d": ("poses", _label(labels, 2, box3d=moved)),
        "reordered corners": ("poses", _label(labels, 2, box3d=block.box3d[::-1])),
        "skew box3d": ("box3d", _label(labels, 2, box3d=squeezed)),
        "small box3d": ("box3d", _label(labels, 2, box3d=shrunk)),
        "moved centroid": ("poses", _label(labels, 1, centroid=block.centroid)),
        "centroid pixel": (
            "poses",
            _label(labels, 1, centroid=ball.centroid.model_copy(update={"pixel": (40.0, 40.0)})),
        ),
        "mask less a pixel": ("masks", _label(labels, 0, mask_amodal=rle)),
        "seen mask less a pixel": ("masks", _label(labels, 0, mask_seen=rle)),
        "mask of another size": ("masks", _label(labels, 2, mask_seen=size)),
        "pixel count": ("masks", _label(labels, 1, **_pixels(ball, visible=ball.pixels.visible + 1))),
        "fractions above 1": (
            "fractions",
            _label(labels, 1, fractions=shares.model_copy(update={"occluded": 1e-9})),
        ),
        "fractions exchanged": (
            "fractions",
            _label(
                labels,
                1,
                fractions=shares.model_copy(update={"visible": shares.seen_through, "seen_through": shares.visible}),
            ),
        ),
        "no fractions": ("fractions", _label(labels, 1, fractions=None)),
        "modal box a pixel wide": (
            "boxes",
            _label(labels, 0, box2d=box.model_copy(update={"modal": (left, top, left + 1, top + 1)})),
        ),
        "amodal box too small": (
            "boxes",
            _label(labels, 0, box2d=box.model_copy(update={"amodal": (left + 1.5, top, right, bottom)})),
        ),
        "amodal box too large": (
            "boxes",
            _label(labels, 0, box2d=box.model_copy(update={"amodal": (left - 30, top, right, bottom)})),
        ),
        "clipped box outside": (
            "boxes",
            _label(labels, 0, box2d=box.model_copy(update={"amodal_clipped": (-4.0, top, right, bottom)})),
        ),
        "no clipped box": ("boxes", _label(labels, 0, box2d=box.model_copy(update={"amodal_clipped": None}))),
        "keypoint off its object": ("keypoints", _label(labels, 1, keypoints=away)),
        "keypoint in the picture called outside": ("keypoints", _label(labels, 2, keypoints=outside)),
        "keypoint behind the camera": ("keypoints", _label(labels, 2, keypoints=nowhere)),
    }


LABEL_NAMES = [
    "swapped objects",
    "turned pose",
    "moved box3d",
    "reordered corners",
    "skew box3d",
    "small box3d",
    "moved centroid",
    "centroid pixel",
    "mask less a pixel",
    "seen mask less a pixel",
    "mask of another size",
    "pixel count",
    "fractions above 1",
    "fractions exchanged",
    "no fractions",
    "modal box a pixel wide",
    "amodal box too small",
    "amodal box too large",
    "clipped box outside",
    "no clipped box",
    "keypoint off its object",
    "keypoint in the picture called outside",
    "keypoint behind the camera",
]


@pytest.mark.parametrize("name", LABEL_NAMES)
def test_a_fault_of_the_labels_is_found(view, name):
    scene, camera, labels, geometry, _ = view
    cases = _wrong_labels(labels, geometry)
    assert sorted(cases) == sorted(LABEL_NAMES)
    check, broken = cases[name]
    found = checks.check_view(scene, camera, broken, geometry)
    assert check in {violation.check for violation in found}
    assert all(violation.where and violation.expected and violation.found for violation in found)


def test_a_keypoint_on_a_strip_thinner_than_a_pixel_needs_no_pixel_beside_it(view) -> None:
    _, camera, labels, geometry, _ = view
    ball = labels.objects[1]
    rows, columns = np.nonzero(geometry.crossed[1])
    # A corner of the box around a round object is in its span, and none of its pixels.
    place = (float(columns.min()), float(rows.min()))
    corner = ball.keypoints[1].model_copy(update={"pixel": place, "state": "visible", "Z": 1.0})
    moved = _label(labels, 1, keypoints=(corner, *ball.keypoints[1:]))
    assert [found.check for found in checks.check_keypoints(moved, camera)] == ["keypoints"]
    assert not checks.check_keypoints(moved, camera, [ball.id])
