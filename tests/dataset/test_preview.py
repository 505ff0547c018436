from __future__ import annotations

import numpy as np

from glassware.dataset.pictures import srgb8
from glassware.dataset.preview import (
    PreviewRow,
    chosen_views,
    contact_sheet,
    depth_colours,
    id_colours,
    normal_colours,
)


def test_a_sheet_shows_at_most_five_views_evenly_spread():
    assert chosen_views(57) == [0, 14, 28, 42, 56]
    assert chosen_views(3) == [0, 1, 2]
    assert chosen_views(1) == [0]


def test_a_sheet_has_a_row_per_view_and_draws_on_the_pictures_it_says(made):
    scene, _, views = made
    rows = [
        PreviewRow(f"{v.number:03d}", srgb8(v.frame.left, 1.0), scene.cameras[v.number], v.frame.geometry, v.labels)
        for v in views
    ]
    one, two = contact_sheet("one", rows[:1]), contact_sheet("two", rows)
    assert two.dtype == np.uint8
    assert two.shape[0] > one.shape[0]
    assert two.shape[1] == one.shape[1]
    bare = [
        PreviewRow(r.name, r.picture, r.camera, r.geometry, r.labels.model_copy(update={"objects": ()})) for r in rows
    ]
    # Boxes, axes, keypoints and ids are drawn in the last three columns and nowhere else.
    columns = np.flatnonzero((contact_sheet("two", bare) != two).any(axis=(0, 2)))
    assert columns.min() >= two.shape[1] / 2
    assert len(columns) > 100


def test_depth_colours_span_the_objects_and_near_is_brighter():
    Z = np.array([[0.2, 0.5, 0.7, 9.0, np.inf]], np.float32)
    ids = np.array([[1, 2, 3, 1, 0]], np.uint16)
    colours, (near, far) = depth_colours(Z, ids)
    assert (near, far) == (np.float32(0.5), np.float32(0.7))
    assert colours[0, 1].sum() > colours[0, 2].sum()
    assert (colours[0, 0] == colours[0, 1]).all()  # before the range
    assert (colours[0, 3] == colours[0, 2]).all()  # behind it
    assert (colours[0, 4] != colours[0, 2]).any()


def test_an_empty_view_has_colours_too():
    Z = np.full((2, 3), np.inf, np.float32)
    assert depth_colours(Z, np.zeros((2, 3), np.uint16))[0].shape == (2, 3, 3)
    assert id_colours(np.zeros((2, 3), np.uint16)).shape == (2, 3, 3)


def test_a_normal_towards_the_camera_is_blue_and_one_upwards_is_green():
    colours = normal_colours(np.array([[[0, 0, -1], [0, -1, 0], [1, 0, 0]]], np.float32))
    assert colours[0].tolist() == [[128, 128, 255], [128, 255, 128], [255, 128, 128]]


def test_ids_of_neighbouring_objects_have_distinct_colours():
    colours = id_colours(np.arange(16, dtype=np.uint16)[None])
    assert len(np.unique(colours[0], axis=0)) == 16
