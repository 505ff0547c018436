from __future__ import annotations

import numpy as np

from glassware.core.images import difference_colours, reason_colours, srgb8
from glassware.dataset.preview.contact_sheet import (
    PreviewRow,
    chosen_views,
    contact_sheet,
    depth_caption,
    depth_colours,
    id_colours,
    normal_colours,
    number_position,
)
from glassware.dataset.preview.sensor_cells import SensorPreview


def test_a_sheet_shows_at_most_five_views_evenly_spread():
    assert chosen_views(57) == [0, 14, 28, 42, 56]
    assert chosen_views(3) == [0, 1, 2]
    assert chosen_views(1) == [0]


def test_a_sheet_has_a_row_per_view_and_draws_on_the_pictures_it_says(made):
    scene, _, views = made
    rows = [
        PreviewRow(f"{i:03d}", srgb8(view.frame.left, 1.0), scene.cameras[i], view.frame.geometry, view.labels)
        for i, view in enumerate(views)
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


def test_a_caption_says_where_depths_beyond_the_range_take_its_colours():
    Z = np.array([[0.2, 0.5, 0.7, 9.0, np.inf]], np.float32)
    _, (near, far) = depth_colours(Z, np.array([[1, 2, 3, 1, 0]], np.uint16))
    assert depth_caption(Z, near, far) == "<= 0.50 m to >= 0.70 m"
    assert depth_caption(Z[:, 1:3], near, far) == "0.50 m to 0.70 m"
    assert depth_caption(Z[:, 1:], near, far) == "0.50 m to >= 0.70 m"


def test_a_number_lies_inside_its_region_also_where_the_middle_of_the_box_does_not():
    region = np.zeros((60, 80), bool)
    region[5:55, 10:70] = True
    region[5:40, 22:58] = False  # a U: the middle of its box is outside it
    (x, y), fits = number_position(region, 9, 7)
    assert fits
    assert region[y - 3 : y + 4, x - 4 : x + 5].all()
    wide, fits = number_position(region, 41, 7)
    assert fits
    assert region[wide[1] - 3 : wide[1] + 4, wide[0] - 20 : wide[0] + 21].all()


def test_a_number_that_fits_nowhere_is_where_its_region_is_thickest():
    region = np.zeros((20, 40), bool)
    region[10, 5:30] = True
    region[8:13, 20:25] = True
    assert number_position(region, 9, 7) == ((22, 10), False)


def test_the_edge_of_the_picture_is_a_border_of_a_region():
    region = np.zeros((40, 40), bool)
    region[:, 30:] = True
    (x, y), fits = number_position(region, 9, 7)
    assert fits
    assert 34 <= x <= 35
    assert 3 <= y <= 36


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


def test_a_sheet_of_a_depth_camera_shows_its_depth_how_far_it_lies_behind_and_why_there_is_none(made):
    scene, _, views = made
    view = views[0]
    geometry, picture = view.frame.geometry, srgb8(view.frame.left, 1.0)
    depth = np.where(np.isfinite(geometry.Z), geometry.Z, np.nan)
    measured = np.isfinite(depth).astype(np.uint16)

    def sheet(sensor):
        return contact_sheet("one", [PreviewRow("000", picture, scene.cameras[0], geometry, view.labels, sensor)])

    def reported(more=0.0, reason=measured, infrared=None):
        return sheet(SensorPreview(depth + more, reason, ("unseen", "measured", "no_match"), infrared))

    plain, right = sheet(None), reported()
    cell = (right.shape[1] - plain.shape[1]) // 3
    columns = np.flatnonzero((right != reported(0.05)).any(axis=(0, 2)))
    assert plain.shape[1] <= columns.min()
    assert columns.max() < plain.shape[1] + 2 * cell
    lost = reported(reason=np.where(measured == 1, 2, 0).astype(np.uint16))
    columns = np.flatnonzero((right != lost).any(axis=(0, 2)))
    assert columns.min() >= plain.shape[1] + 2 * cell
    # The colour of `no_match` is there, and a disc of it beside its name.
    assert (lost[:, plain.shape[1] + 2 * cell :] == reason_colours(np.array(2))).all(axis=2).sum() > 100
    infrared = reported(infrared=np.full((20, 40), 200, np.uint16))
    assert infrared.shape[1] == right.shape[1] + cell
    assert (infrared[:, right.shape[1] :] == 200).all(axis=2).sum() > 0.4 * cell * cell / 2
    assert difference_colours(np.array([[0.05, -0.05, 0.0, np.nan]]), 0.05)[0].tolist() == [
        [178, 24, 43],
        [33, 102, 172],
        [255, 255, 255],
        [45, 45, 48],
    ]
