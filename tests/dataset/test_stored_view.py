"""Labels that follow from a stored view's files."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.annotate.heatmap import heatmap
from glassware.annotate.stereo import BOTH, HIDDEN, NOTHING, OUTSIDE
from glassware.core.errors import InputError
from glassware.dataset.exports.run import export
from glassware.dataset.format.map_files import HEAT_STEPS, read_ids
from glassware.dataset.reader import Dataset


@pytest.fixture(scope="module")
def view(proven):
    (view,) = Dataset.open(proven).views()
    return view


@pytest.fixture
def bare(stored):
    """A view without any file on request but those of earlier versions."""
    return Dataset.open(stored).views()[0]


def test_disparity_is_that_of_the_depth_of_each_eye(view):
    camera = view.camera()
    for eye in ("left", "right"):
        geometry = view.geometry(eye)
        for background, depth in ((False, geometry.Z), (True, geometry.background_Z)):
            np.testing.assert_allclose(view.disparity(eye, background), camera.fx * camera.baseline / depth, rtol=1e-6)


def test_pixels_that_both_eyes_see_have_the_same_depth_in_both(view):
    camera, left, right = view.camera(), view.geometry(), view.geometry("right")
    seen = view.pair_visibility().first
    assert set(np.unique(seen)) <= {BOTH, HIDDEN, OUTSIDE, NOTHING}
    assert {BOTH, HIDDEN, OUTSIDE} <= set(np.unique(seen))
    assert ((seen == NOTHING) == np.isinf(left.Z)).all()
    flat = (left.id == 1) & (seen == BOTH)  # 1 / Z is linear along a row of the table
    rows, columns = np.nonzero(flat)
    landed = columns - view.disparity()[flat]
    inverse = np.where(right.id == 1, 1.0 / right.Z.astype(float), np.nan)
    found = [np.interp(u, np.arange(camera.width), inverse[row]) for u, row in zip(landed, rows, strict=True)]
    kept = np.isfinite(found)
    assert kept.sum() > 100
    np.testing.assert_allclose(np.array(found)[kept], 1.0 / left.Z[flat][kept], rtol=1e-4)


def test_the_heatmap_of_a_view_is_that_of_its_file(view):
    stored = read_ids(view.folder / "heatmap.png") / HEAT_STEPS
    np.testing.assert_allclose(view.heatmap(), stored, atol=1.0 / HEAT_STEPS)
    assert (heatmap([], (3, 4)) == 0).all()


def test_back_walls_from_their_file_are_those_from_layers(view, tmp_path, copy):
    (other,) = Dataset.open(copy).views()
    (other.folder / "coordinates.exr").unlink()
    np.testing.assert_allclose(view.object_coordinates(back=True), other.object_coordinates(back=True), atol=6e-4)


def test_lines_of_vessels_are_those_of_objects_json(view, proven):
    records = Dataset.open(proven).scenes[0].objects().objects
    assert {name: [len(line) for line in lines] for name, lines in view.openings().items()} == {
        record.name: [len(line) for line in record.openings] for record in records if record.material.kind == "glass"
    }
    assert all(lines for lines in view.fill_lines().values())
    parts = view.vessel_parts()
    for name, (mouth, *_) in view.openings().items():
        assert parts[name].opening.any() or not np.isfinite(mouth).all()


def test_mattes_are_the_masks_but_for_edges(view):
    mattes, geometry = view.mattes(), view.geometry()
    assert mattes.coverage.shape == geometry.reached.shape
    assert np.abs(mattes.coverage - geometry.reached).mean() < 0.02
    certain = mattes.coverage == 1.0
    assert geometry.reached[certain].all()
    total = np.sum([*mattes.first.values()], axis=0)
    assert (total[geometry.id > 0] > 0.0).all()
    np.testing.assert_array_equal(mattes.coverage * 16, np.rint(mattes.coverage * 16))


def test_flow_is_between_views_of_one_scene(view, bare):
    assert np.nanmax(np.abs(view.flow(view))) < 1e-6
    with pytest.raises(InputError, match="other: expected a view of the same scene"):
        view.flow(bare)


@pytest.mark.parametrize(
    ("ask", "kind"),
    [
        (lambda view: view.geometry("right"), "right-labels"),
        (lambda view: view.labels("right"), "right-labels"),
        (lambda view: view.disparity("right"), "disparity"),
        (lambda view: view.pair_visibility(), "disparity"),
        (lambda view: view.object_coordinates(back=True), "coordinates"),
        (lambda view: view.vessel_parts(), "layers"),
        (lambda view: view.mattes(), "mattes"),
    ],
)
def test_a_label_that_is_not_there_says_how_it_is_made(bare, ask, kind):
    with pytest.raises(InputError, match=f"expected a data set with {kind}, made with --write {kind}"):
        ask(bare)


def test_exports_take_a_data_set_with_all_labels(proven, tmp_path):
    assert export(proven, "coco", tmp_path / "out").scenes == 1
