from __future__ import annotations

import numpy as np
import pytest

from glassware.annotate.projection import project
from glassware.core.errors import InputError
from glassware.learn.data.ground_truth import GroundTruth
from glassware.learn.data.samples import SampleDataset
from glassware.learn.data.scaling import (
    BORDER,
    fitted,
    restored,
    restored_points,
    scaled_ground_truth,
    scaled_K,
    scaled_view,
)
from glassware.learn.data.settings import ViewSettings
from glassware.learn.data.views import CameraView
from glassware.learn.targets.encoding import CORRECTED

SIZES = [(96, 128), (64, 192), (224, 320)]
OLD = (96, 128)
K = np.array([[150.0, 0.0, 62.0], [0.0, 140.0, 50.0], [0.0, 0.0, 1.0]])


def centres(old: int, new: int) -> np.ndarray:
    """Where the centres of new pixels lie among the old ones."""
    return (np.arange(new) + 0.5) * old / new - 0.5


@pytest.mark.parametrize("size", SIZES)
def test_a_scaled_picture_shows_each_point_where_its_scaled_camera_does(size):
    """The picture is a ramp whose value is the place, so each pixel tells where it was."""
    v, u = np.mgrid[: OLD[0], : OLD[1]]
    picture = np.stack([u, v, np.zeros_like(u)], axis=-1).astype(np.uint8)
    view = scaled_view(CameraView(picture, np.eye(4), K), size, "stretch")
    down, across = (centres(old, new) for old, new in zip(OLD, size, strict=True))
    # Values are rounded to integers, and at the borders interpolation repeats the last one.
    inside = np.s_[3:-3, 3:-3]
    rows, columns = np.meshgrid(down, across, indexing="ij")
    np.testing.assert_allclose(view.picture[..., 0][inside], columns[inside], atol=0.51)
    np.testing.assert_allclose(view.picture[..., 1][inside], rows[inside], atol=0.51)

    points = np.random.default_rng(1).uniform((-0.2, -0.2, 0.5), (0.2, 0.2, 2.0), (100, 3))
    before, _ = project(points, K, np.eye(4))
    after, _ = project(points, view.K, np.eye(4))
    scale = np.array([size[1] / OLD[1], size[0] / OLD[0]])
    np.testing.assert_allclose(after, (before + 0.5) * scale - 0.5, rtol=0, atol=1e-10)


@pytest.mark.parametrize("size", SIZES)
def test_scaled_labels_are_those_of_the_pixels_that_centres_lie_in(size):
    Z = np.random.default_rng(2).uniform(0.5, 1.0, OLD).astype(np.float32)
    truth = scaled_ground_truth(GroundTruth((Z * 100).astype(np.uint16), Z, (), {}), size, "stretch")
    down, across = (centres(old, new) for old, new in zip(OLD, size, strict=True))
    rows, columns = (np.floor(x + 0.5).astype(int) for x in (down, across))
    np.testing.assert_array_equal(truth.Z, Z[np.ix_(rows, columns)])
    np.testing.assert_array_equal(truth.instances, (Z * 100).astype(np.uint16)[np.ix_(rows, columns)])


@pytest.mark.parametrize("size", [(64, 192), (224, 320), (160, 128)])
def test_a_letterboxed_picture_keeps_its_shape_and_its_camera(size):
    """Square pixels stay square, points and labels lie where the picture shows them, and the border shows nothing."""
    v, u = np.mgrid[: OLD[0], : OLD[1]]
    picture = np.stack([u, v, np.zeros_like(u)], axis=-1).astype(np.uint8)
    view, fit = scaled_view(CameraView(picture, np.eye(4), K), size), fitted(OLD, size)
    scale = view.K[0, 0] / K[0, 0]
    assert view.K[1, 1] / K[1, 1] == pytest.approx(scale, rel=0.5 / min(fit.inner))  # whole pixels
    assert scale == pytest.approx(min(size[0] / OLD[0], size[1] / OLD[1]), rel=0.5 / min(fit.inner))
    border = np.ones(size, bool)
    border[fit.inside] = False
    assert border.any()
    assert (view.picture[border] == BORDER).all()

    points = np.random.default_rng(1).uniform((-0.2, -0.2, 0.8), (0.2, 0.2, 2.0), (100, 3))
    before, _ = project(points, K, np.eye(4))
    after, _ = project(points, view.K, np.eye(4))
    np.testing.assert_allclose(restored_points(after, fit), before, atol=1e-9)
    cells = np.rint(after).astype(int)
    inside = ~border[cells[:, 1], cells[:, 0]]
    shown = view.picture[cells[inside, 1], cells[inside, 0], :2].astype(float)
    np.testing.assert_allclose(shown, before[inside], atol=1.0 / min(1.0, scale) + 0.5)

    Z = np.random.default_rng(2).uniform(0.5, 1.0, OLD).astype(np.float32)
    truth = scaled_ground_truth(GroundTruth(np.ones(OLD, np.uint16), Z, (), {}), size)
    assert (truth.instances[border] == 0).all()
    assert np.isinf(truth.Z[border]).all()
    assert np.isfinite(truth.Z[~border]).all()
    again = restored(truth.Z, fit)
    if scale >= 1.0:  # nothing is lost when a picture is enlarged
        np.testing.assert_array_equal(again, Z)
    assert again.shape == OLD


def test_a_picture_of_the_right_shape_fills_the_size():
    assert fitted((480, 640), (96, 128)).inner == (96, 128)
    assert fitted((720, 1280), (128, 160)).inner == (90, 160)
    assert fitted((720, 1280), None).new == (720, 1280)


def test_scaling_to_another_size_and_back_gives_the_camera_back():
    np.testing.assert_allclose(scaled_K(scaled_K(K, OLD, (64, 192)), (64, 192), OLD), K, rtol=1e-14)


def test_samples_come_at_the_size_that_is_asked_for(rendered):
    stored = SampleDataset(rendered, "all", ViewSettings(), CORRECTED, ground_truth=True)[(3, 0)]
    sample = SampleDataset(rendered, "all", ViewSettings(size=(64, 96), fit="stretch"), CORRECTED, ground_truth=True)[
        (3, 0)
    ]
    assert sample.images.shape == (2, 3, 64, 96)
    assert sample.targets["depth"].shape == (64, 96)
    for ours, theirs in zip(sample.K.double().numpy(), stored.K.double().numpy(), strict=True):
        np.testing.assert_allclose(ours, scaled_K(theirs, (96, 128), (64, 96)), rtol=1e-6)
    truth, whole = sample.ground_truth, stored.ground_truth
    assert truth is not None
    assert whole is not None
    assert [item.id for item in truth.objects] == [item.id for item in whole.objects]
    for ours, theirs in zip(truth.objects, whole.objects, strict=True):
        assert ours.visible == (truth.instances == ours.id).sum()
        # Both count the same area, up to the pixels along its outline.
        assert ours.visible == pytest.approx(theirs.visible / 2, abs=4 * (1 + np.sqrt(theirs.visible)))
        np.testing.assert_array_equal(ours.corners, theirs.corners)


@pytest.mark.parametrize("size", [(60, 96), (0, 32), (64,)])
def test_a_size_that_networks_cannot_take_is_refused(size):
    with pytest.raises((InputError, ValueError), match="size"):
        ViewSettings(size=size)
