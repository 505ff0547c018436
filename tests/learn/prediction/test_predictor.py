"""A network from Python: pictures in, arrays out, in the pixels and the frame of the picture that was given."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
import torch

from glassware.annotate.masks import decode_mask
from glassware.core.errors import InputError
from glassware.dataset.cameras.model import Distortion
from glassware.dataset.format.exr import read_exr
from glassware.dataset.format.pictures import read_png, write_png
from glassware.dataset.reader import Dataset
from glassware.learn import Prediction, build_network, load
from glassware.learn.prediction.drawing import drawn
from glassware.learn.prediction.predict import object_records, predict
from glassware.learn.prediction.predictor import Predictor
from glassware.learn.prediction.rigs import RigOptions
from glassware.learn.training.settings import TrainSettings
from glassware.learn.training.weights import WeightsHeader, write_weights


@pytest.fixture
def weights(tiny, tmp_path):
    """A new network whose heat map is not 0, as a file; its peaks lie where they will."""
    network = build_network(tiny)
    torch.nn.init.normal_(network.get_parameter("heatmap_head.predictor.weight"), std=0.5)
    header = WeightsHeader(
        name="tiny", glassware="0", network=tiny, views=TrainSettings().views, step=0, data=None, focal=60.0
    )
    write_weights(tmp_path / "tiny.safetensors", header, network.state_dict())
    return tmp_path / "tiny.safetensors"


@pytest.fixture
def view(rendered):
    return Dataset.open(rendered).scene(1).views[3]


def two(count: int = 2) -> Prediction:
    """A prediction of one glass and one opaque object at known places."""
    pose, mask = np.tile(np.eye(4), (count, 1, 1)), np.zeros((count, 96, 128), bool)
    for row in range(count):
        pose[row, :3, 3] = (-0.1 + 0.2 * row, 0.0, 1.0)
        mask[row, 30:60, 30 + 50 * row : 50 + 50 * row] = True
    return Prediction(
        depth=np.tile(np.linspace(0.5, 1.5, 128, dtype=np.float32), (96, 1)),
        score=np.array([0.9, 0.5])[:count],
        transparent=np.array([True, False])[:count],
        camera_T_object=pose,
        size=np.full((count, 3), 0.1),
        mask=mask,
        peak=np.array([[40.0, 45.0], [90.0, 45.0]])[:count],
        K=np.array([[100.0, 0.0, 63.5], [0.0, 100.0, 47.5], [0.0, 0.0, 1.0]]),
        distortion=Distortion(),
        left_out=0,
    )


def test_three_lines_give_depth_masks_and_boxes_and_the_command_writes_the_same(weights, view, tmp_path):
    record = view.camera_record()
    rig = {"baseline": record.baseline, "focal": record.K[0][0]}
    network = load(weights)
    found = network.stereo(view.folder / "left.png", view.folder / "right.png", **rig)
    assert (found.depth.shape, found.depth.dtype) == ((96, 128), np.float32)
    assert found.mask.shape == (len(found), 96, 128)
    assert found.corners.shape == (len(found), 8, 3)
    arrays = network.stereo(read_png(view.folder / "left.png"), read_png(view.folder / "right.png"), **rig)
    np.testing.assert_array_equal(arrays.depth, found.depth)
    pictures = [view.folder / "left.png", view.folder / "right.png"]
    predict(weights, pictures, tmp_path / "out", rig=RigOptions(**rig))
    np.testing.assert_array_equal(read_exr(tmp_path / "out" / "depth.exr")["Z"], found.depth)
    objects = json.loads((tmp_path / "out" / "prediction.json").read_text())["objects"]
    assert [one["score"] for one in objects] == found.score.tolist()


def test_a_picture_of_less_than_half_of_the_networks_size_is_refused(weights):
    small = np.random.default_rng(0).integers(0, 255, (40, 64, 3), dtype=np.uint8)
    network = load(weights)
    sized = network.settings.model_copy(update={"views": network.settings.views.model_copy(update={"size": (96, 128)})})
    with pytest.raises(InputError, match="left: expected a picture of at least 64 x 48 px, found 64 x 40 px"):
        replace(network, settings=sized).stereo(small, np.roll(small, -2, 1), baseline=0.06, focal=60.0)


def test_scores_are_at_most_1_though_heat_is_a_regression(weights, view):
    record = view.camera_record()
    network = load(weights)
    outputs = network.network

    class Hotter(torch.nn.Module):
        def forward(self, *given):
            found = outputs(*given)
            return found | {"heatmap": found["heatmap"] - found["heatmap"].amax() + 1.1}

    pictures = [view.folder / "left.png", view.folder / "right.png"]
    found = replace(network, network=Hotter()).stereo(*pictures, baseline=record.baseline, focal=record.K[0][0])
    assert len(found)
    assert found.score[0] == 1.0
    assert (np.diff(found.score) <= 0.0).all()


def test_views_by_their_poses_give_what_the_same_pair_gives_as_a_stereo_camera(weights, view):
    record = view.camera_record()
    K, network = np.array(record.K), load(weights)
    pictures = [read_png(view.folder / f"{eye}.png") for eye in ("left", "right")]
    by_poses = network.views(pictures, K, [record.world_T_camera, record.world_T_right])
    again = network.views(
        pictures, np.stack([K, K]), [np.eye(4), np.linalg.inv(record.world_T_camera) @ record.world_T_right]
    )
    np.testing.assert_allclose(by_poses.depth, again.depth, atol=1e-4)
    with pytest.raises(InputError, match="world_T_camera: expected a pose for each of 2 pictures, found 1"):
        network.views(pictures, K, [np.eye(4)])


def test_a_turned_and_bent_picture_gives_the_depth_of_the_straight_one(weights, view):
    """The pair again, as if a lens had bent the left eye's picture: depth is that of the same pixels, moved."""
    record = view.camera_record()
    K, lens = np.array(record.K), Distortion(k1=0.08)
    network = load(weights)
    straight = network.stereo(
        view.folder / "left.png", view.folder / "right.png", baseline=record.baseline, focal=K[0, 0]
    )
    y, x = np.mgrid[:96, :128].astype(np.float32)
    points = cv2.undistortPoints(np.stack([x, y], -1).reshape(-1, 1, 2), K, np.array(lens.coefficients), P=K)
    at = points.reshape(96, 128, 2).astype(np.float32)
    bent = cv2.remap(read_png(view.folder / "left.png"), at[..., 0], at[..., 1], cv2.INTER_LINEAR)
    own = [
        replace(one, picture=picture, distortion=one_lens)
        for one, picture, one_lens in zip(
            network_pair(record, K), (bent, read_png(view.folder / "right.png")), (lens, Distortion()), strict=True
        )
    ]
    found = network.predict(own, ["left", "right"])
    expected = cv2.remap(
        straight.depth,
        at[..., 0],
        at[..., 1],
        cv2.INTER_NEAREST,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=float("nan"),
    )
    inside = np.isfinite(expected) & np.isfinite(found.depth)
    inside[:12], inside[-12:], inside[:, :12], inside[:, -12:] = False, False, False, False  # convolutions see borders
    assert inside.mean() > 0.4
    # Resampled twice, the picture is a little softer.
    assert np.median(np.abs(found.depth - expected)[inside]) < 0.02


def network_pair(record, K):
    from glassware.learn.prediction.own_pictures import OwnPicture

    right = np.eye(4)
    right[0, 3] = record.baseline
    empty = np.zeros((96, 128, 3), np.uint8)
    return [OwnPicture(empty, pose, K, Distortion()) for pose in (np.eye(4), right)]


def test_a_network_without_heat_finds_none_and_says_so(tiny, view, tmp_path, capsys):
    """A new network predicts no heat at all: that is an empty picture, not an object."""
    from glassware.dataset.commands.glassware import main

    header = WeightsHeader(name="new", glassware="0", network=tiny, views=TrainSettings().views, step=0, data=None)
    write_weights(tmp_path / "new.safetensors", header, build_network(tiny).state_dict())
    pictures = [str(view.folder / f"{eye}.png") for eye in ("left", "right")]
    arguments = ["predict", str(tmp_path / "new.safetensors"), *pictures, "--device", "cpu", "--threads", "1"]
    assert main([*arguments, "--out", str(tmp_path / "out")]) == 0
    assert "no objects found; written to" in capsys.readouterr().out
    assert json.loads((tmp_path / "out" / "prediction.json").read_text())["objects"] == []


def test_a_drawing_shows_masks_boxes_and_depth_where_they_are():
    picture = np.full((96, 128, 3), 128, np.uint8)
    found = two()
    shown = drawn(picture, found)
    over, depth = shown[: 5 * 96, : 5 * 128], shown[: 5 * 96, 5 * 128 : 10 * 128]
    assert (over[5 * 5, 5 * 5] == 128).all()  # nothing there
    tinted = over[5 * 58 + 2, 5 * 31 + 2].astype(int)  # in the first mask: red is above the rest
    assert tinted[0] > tinted[1] + 10
    assert depth[100, 5].astype(int)[0] > depth[100, 5].astype(int)[2]  # near is red
    empty, strips = drawn(picture, two(0)), shown[5 * 96 :]
    np.testing.assert_array_equal(empty[: 5 * 96, : 5 * 128], np.full((480, 640, 3), 128))
    assert empty[5 * 96 :].max() > 200  # it says that there is none
    assert strips.shape != empty[5 * 96 :].shape or not np.array_equal(strips, empty[5 * 96 :])


def test_records_have_the_class_the_box_and_the_mask_of_each_object():
    found = two()
    first, second = object_records(found)
    assert (first["category"], second["category"]) == ("transparent", "opaque")
    np.testing.assert_allclose(np.mean(first["corners"], axis=0), [-0.1, 0.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(np.ptp(second["corners"], axis=0), 0.1)
    for record, mask in zip((first, second), found.mask, strict=True):
        assert record["pixels"] == mask.sum()
        np.testing.assert_array_equal(decode_mask(record["mask"]["counts"], mask.shape), mask)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            lambda picture: np.zeros_like(picture),
            r"left: expected a picture in which something shows, found a dark one",
        ),
        (
            lambda picture: np.full_like(picture, 130),
            r"left: expected a picture in which .*, found a blank one of about 130",
        ),
        (lambda picture: picture[..., 0], r"left: expected a picture, \(H, W, 3\) uint8, or its file, found uint8 of"),
        (lambda picture: picture / 255.0, r"left: expected a picture, \(H, W, 3\) uint8, or its file, found float64"),
    ],
)
def test_a_wrong_picture_is_one_clear_line(weights, view, change, said):
    picture = read_png(view.folder / "left.png")
    with pytest.raises(InputError, match=said):
        load(weights).stereo(change(picture), picture, baseline=0.06, fov=math.radians(60))


def test_pictures_of_a_wide_lens_are_seen_in_windows(weights, view, tmp_path):
    """The weights were trained at a focal length of 60 px of 128 x 96: a picture of twice the size with the same one is
    seen in windows, and what is found lies in its own pixels."""
    network = load(weights)
    sized = Predictor(
        network.network,
        network.settings.model_copy(update={"views": network.settings.views.model_copy(update={"size": (96, 128)})}),
        network.focal,
        "cpu",
    )
    pictures = [cv2.resize(read_png(view.folder / f"{eye}.png"), (256, 192)) for eye in ("left", "right")]
    for number, picture in enumerate(pictures):
        write_png(tmp_path / f"{number}.png", picture)
    found = sized.stereo(tmp_path / "0.png", tmp_path / "1.png", baseline=0.06, focal=60.0)
    assert found.depth.shape == (192, 256)
    assert np.isfinite(found.depth).all()
    assert found.K[0, 0] == 60.0


def test_windows_of_both_eyes_meet_at_the_depth_of_the_training_pairs(weights, view):
    network, seen = load(weights), []

    class Watched(torch.nn.Module):
        def forward(self, images, world_T_camera, K):
            seen.append(K[0].numpy())
            return network.network(images, world_T_camera, K)

    views = network.settings.views.model_copy(update={"size": (96, 128), "convergence": 0.4})
    sized = replace(network, network=Watched(), settings=network.settings.model_copy(update={"views": views}))
    pictures = [cv2.resize(read_png(view.folder / f"{eye}.png"), (256, 192)) for eye in ("left", "right")]
    sized.stereo(pictures[0], pictures[1], baseline=0.06, focal=60.0)
    # At 0.4 m the disparity is 9 px, and windows of as many pixels as the network's are moved by it where they can.
    apart = np.array([right[0, 2] - left[0, 2] for left, right in seen])
    assert len(apart) == 9
    np.testing.assert_allclose(
        apart[np.arange(9) % 3 > 0], 9.0
    )  # in the first of each row there is nothing to the left
    np.testing.assert_allclose(apart[::3], 0.0)
