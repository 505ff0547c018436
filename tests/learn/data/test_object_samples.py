"""Samples of networks that see one object: windows, keypoints, points of depth, models."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from scipy.spatial import cKDTree

from glassware.learn.data.densefusion_samples import DenseFusionSamples, raw_depth, true_depth
from glassware.learn.data.keypose_samples import KeyPoseSamples
from glassware.learn.data.object_cases import Finding, object_cases, too_small
from glassware.learn.data.samples import SampleDataset
from glassware.learn.data.scaling import scaled_depth
from glassware.learn.data.semi_global import filled_depth, semi_global_depth
from glassware.learn.data.settings import ViewSettings
from glassware.learn.data.views import CameraView
from glassware.learn.decoding.keypoints import points_in_space
from glassware.learn.networks.baselines.settings import DenseFusionSettings, KeyPoseSettings
from glassware.learn.targets.encoding import CORRECTED

CROP = (32, 48)
#: Rounding of float32 at a metre, through a disparity of some pixels.
ROUNDING = 1e-4
#: How far the depth of a pixel, which may be cut by an edge, lies from the nearest of 2,000 points of a surface [m].
ON_SURFACE = 0.02


@pytest.fixture(scope="module")
def base(rendered) -> SampleDataset:
    return SampleDataset(rendered, "train", ViewSettings(rule="stereo"), CORRECTED, ground_truth=True)


def keypose(base, **options) -> KeyPoseSamples:
    settings = KeyPoseSettings(crop=CROP, **options.pop("settings", {}))
    return KeyPoseSamples(base, settings, **options)


@pytest.mark.parametrize("flip", [0.0, 1.0])
def test_keypoints_in_both_windows_are_the_points_in_space(base, flip):
    samples = keypose(base, training=True, settings={"flip": flip})
    for index in range(3):
        sample = samples[(index, 4)]
        targets = sample.targets
        K, baseline = sample.K[None].expand(2, -1, -1, -1), targets["baseline"].expand(2)
        found = points_in_space(targets["keypoints"], K, baseline)
        torch.testing.assert_close(found, targets["points"], atol=ROUNDING, rtol=ROUNDING)
        assert bool(targets["projection_mask"].any()) == (not flip)


def test_a_mirrored_pair_has_mirrored_keypoints(base):
    plain, mirrored = (
        keypose(base, training=True, settings={"flip": flip, "dither": 0.0, "augment": "common"})[(0, 0)]
        for flip in (0.0, 1.0)
    )
    # In the mirror the right eye is the left one: x becomes baseline - x.
    moved = plain.targets["points"] * torch.tensor([-1.0, 1.0, 1.0]) + torch.tensor([plain.targets["baseline"], 0, 0])
    torch.testing.assert_close(mirrored.targets["points"], moved, atol=ROUNDING, rtol=ROUNDING)
    torch.testing.assert_close(mirrored.targets["baseline"], plain.targets["baseline"])


def test_windows_are_parts_of_the_pictures(base):
    samples = keypose(base)
    loaded = base.load((samples.cases[0].view, 0))
    sample = samples[(0, 0)]
    for eye, view in enumerate(loaded.views):
        left, top = (round(float(view.K[axis, 2] - sample.K[eye, axis, 2])) for axis in (0, 1))
        window = (sample.images[eye] * 255.0).round().byte().permute(1, 2, 0).numpy()
        rows, columns = (np.arange(size) + start for size, start in zip(CROP, (top, left), strict=True))
        inside = np.ix_((rows >= 0) & (rows < 96), (columns >= 0) & (columns < 128))
        picture = view.picture[np.clip(rows, 0, 95)][:, np.clip(columns, 0, 127)]
        np.testing.assert_array_equal(window[inside], picture[inside])
    middle = sample.targets["keypoints"][0, :, :2].mean(0)
    # The object lies a sixth of the width to the right of the middle.
    assert middle.tolist() == pytest.approx([48 / 2 + 8, 32 / 2], abs=0.51)


def test_other_views_see_the_keypoints_where_their_cameras_do(base):
    samples = keypose(base)
    sample = samples[(0, 0)]
    pose = sample.world_T_camera[0].double().numpy()
    world = sample.targets["points"][0].double().numpy() @ pose[:3, :3].T + pose[:3, 3]
    expected = []
    for other, K, (height, width) in base.cameras(samples.cases[0].view)[1:]:
        seen = (world - other[:3, 3]) @ other[:3, :3] @ K.T
        expected.append(seen[:, :2] / seen[:, 2:] * [2 / width, 2 / height])
    matrices = sample.targets["projections"].double().numpy()[sample.targets["projection_mask"].numpy()]
    points = sample.targets["points"][0].double().numpy()
    assert len(matrices) == len(expected) == 4
    for matrix in matrices:
        seen = points @ matrix[:, :3].T + matrix[:, 3]
        assert min(np.abs(seen[:, :2] / seen[:, 2:] - one).max() for one in expected) < ROUNDING


def test_no_object_is_left_out_without_being_counted(base):
    every = object_cases(base)
    released = keypose(base, released=True)
    assert len(keypose(base)) == len(every)
    assert len(released.cases) + len(released.dropped) == len(every)
    assert released.dropped
    findings = {(every[0].view, every[0].object_id): Finding((60.0, 50.0), np.ones((96, 128), bool))}
    detected = keypose(base, location="detector", findings=findings)
    assert (len(detected), len(detected.missed)) == (1, len(every) - 1)


def densefusion(base, **options) -> DenseFusionSamples:
    settings = {"categories": (), "points": 64, "model_points": 2000, "crop": 40} | options.pop("settings", {})
    samples = DenseFusionSamples(
        base, DenseFusionSettings.model_validate(settings), options.pop("depth_of", true_depth), **options
    )
    return samples.with_categories(samples.categories())


def test_points_of_true_depth_lie_on_the_model_under_the_true_pose(base):
    samples = densefusion(base, training=True)
    for index in range(3):
        targets = {name: value.double().numpy() for name, value in samples[(index, 1)].targets.items()}
        model = targets["model"] @ targets["pose"][:3, :3].T + targets["pose"][:3, 3]
        assert np.median(cKDTree(model).query(targets["cloud"])[0]) < ON_SURFACE


@pytest.mark.parametrize("released", [False, True])
def test_points_are_beside_the_colours_of_their_pixels(base, released):
    samples = densefusion(base, released=released)
    case, sample = samples.cases[0], samples[(0, 0)]
    view = base.load((case.view, 0)).views[0]
    cloud = sample.targets["cloud"].double().numpy()
    x, y = ((cloud[:, a] / cloud[:, 2] * view.K[a, a] + view.K[a, 2]).round().astype(int) for a in (0, 1))
    window = sample.images[0].flatten(1)[:, sample.targets["pixels"]].T.numpy() * 255.0
    difference = np.abs(window - view.picture[y, x]).max(1)
    # Released windows are not resized; the others are interpolated to within a pixel.
    assert (difference.max() < 1.0) if released else (np.median(difference) < 12.0)


def test_an_object_without_depth_is_lost_and_said_to_be(base):
    samples = densefusion(base, depth_of=lambda loaded: np.zeros_like(loaded.labels.Z))
    assert bool(samples[(0, 0)].targets["lost"])
    assert not bool(densefusion(base)[(0, 0)].targets["lost"])


def test_raw_depth_is_that_of_the_depth_camera_where_there_is_one(base):
    loaded = base.load((0, 0))
    assert loaded.sensor_depth is None
    matched = raw_depth(loaded)
    assert (matched > 0.0).any()
    measured = scaled_depth(np.array([[np.nan, 0.5], [0.7, 0.9]], np.float32), (4, 4))
    np.testing.assert_allclose(measured[::2, ::2], [[0.0, 0.5], [0.7, 0.9]])
    np.testing.assert_array_equal(raw_depth(replace(loaded, sensor_depth=measured)), measured)


def test_objects_of_unknown_categories_are_counted(base):
    samples = densefusion(base)
    known = samples.categories()[:1]
    fewer = densefusion(base, settings={"categories": known})
    assert fewer.categories() == known
    assert fewer.unknown
    assert len(fewer) + len(fewer.unknown) == len(samples)


# What is in the first columns of the left eye is beside the picture of the right one, or what is in its last ones.
@pytest.mark.parametrize(("apart", "seen"), [(0, slice(16, None)), (20, slice(4, -12))])
def test_semi_global_matching_finds_a_plane(apart, seen):
    """Also behind the depth at which both pictures show the same, of cameras whose principal points are apart."""
    wide = np.random.default_rng(4).integers(0, 256, (64, 200, 3)).astype(np.uint8)
    disparity, K, pose = 12, np.array([[100.0, 0.0, 63.5], [0.0, 100.0, 31.5], [0.0, 0.0, 1.0]]), np.eye(4)
    pose[0, 3] = 0.06
    first = 20 + disparity - apart
    left = CameraView(wide[:, 20:148], np.eye(4), K - np.outer([1, 0, 0], [0, 0, apart]))
    depth = semi_global_depth(left, CameraView(wide[:, first : first + 128], pose, K))
    inside = depth[:, seen]
    known = inside > 0.0
    assert known.mean() > 0.8
    # Steps are of 1/16 px, and blocks at the border of what both eyes see are cut.
    assert np.abs(100.0 * 0.06 / inside[known] - disparity).max() <= 0.25
    assert (filled_depth(depth) > 0.0).all()


def test_holes_take_the_farther_depth_beside_them():
    depth = np.array([[0.0, 2.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0]], np.float32)
    expected = [[2.0, 2.0, 2.0, 1.0, 1.0], [1.5, 1.5, 1.5, 1.5, 1.5]]
    np.testing.assert_allclose(filled_depth(depth), expected)


def test_objects_that_are_too_small_to_be_found_are_counted(rendered):
    sizes = ViewSettings(rule="stereo", size=(32, 32), fit="stretch")
    small = SampleDataset(rendered, "all", sizes, CORRECTED, ground_truth=True)
    seen = [item for index in range(len(small)) for item in small.labels(index).objects if item.visible > 0]
    assert len(object_cases(small)) + too_small(small) == len(seen)
    assert 0 < too_small(small) == sum(item.visible < 16 for item in seen)
