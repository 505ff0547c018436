"""DREDS' files, read as SwinDRNet's loader reads them."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import pytest

from glassware.dataset.exports.completion.dreds import BACKGROUND, mask_values
from glassware.dataset.exports.run import export
from glassware.dataset.format.exr import read_exr
from glassware.dataset.reader import Dataset


@pytest.fixture
def out(stored, add_sensor_depth, tmp_path):
    export(add_sensor_depth(stored), "dreds", tmp_path / "out")
    return tmp_path / "out" / "train" / "00000"


def load_meta(path):
    """Fields of each line, by the positions that the loader has."""
    found = []
    for line in path.read_text().splitlines():
        words = line.split(" ")
        assert len(words) == 13
        found.append(
            {
                "index": int(words[0]),
                "label": int(words[1]),
                "scale": float(words[4]),
                "material": int(words[5]),
                "quaternion": [float(word) for word in words[6:10]],
                "translation": [float(word) for word in words[10:13]],
            }
        )
    return found


def instances(path):
    return np.array(read_exr(path)["R"] * 255, dtype=np.int32)


def turned(w, x, y, z):
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def test_masks_and_materials_are_those_of_the_view(stored, out):
    for view in Dataset.open(stored).views():
        mask, geometry = instances(out / f"{view.number:04d}_mask.exr"), view.geometry()
        meta, labels = load_meta(out / f"{view.number:04d}_meta.txt"), view.labels().objects
        for row, label in zip(meta, labels, strict=True):
            np.testing.assert_array_equal(mask == row["index"], geometry.id == label.id)
            assert row["material"] == (2 if label.id == 2 else 1)
        assert (mask[~np.isin(geometry.id, [label.id for label in labels])] == BACKGROUND).all()


def test_every_number_survives_the_cut_of_the_loader():
    numbers = np.arange(256)
    np.testing.assert_array_equal(np.array(mask_values(numbers) * 255, dtype=np.int32), numbers)
    assert mask_values(numbers).dtype == np.float32


def test_depths_are_the_true_and_the_measured_one(stored, out):
    for view in Dataset.open(stored).views():
        stem, Z = f"{view.number:04d}", view.geometry().Z
        for channel in "RGB":
            true = read_exr(out / f"{stem}_depth_120.exr")[channel]
            np.testing.assert_array_equal(true, np.where(np.isfinite(Z), Z, 0.0))
        sensed = read_exr(out / f"{stem}_simDepthImage.exr")["B"]
        assert (sensed[::5] == 0.0).all()
        np.testing.assert_allclose(sensed[sensed > 0.0], Z[sensed > 0.0], atol=5.1e-4)
        assert (out / f"{stem}_color.png").read_bytes() == (view.folder / "left.png").read_bytes()


def test_poses_carry_coordinates_to_the_points_that_are_seen(stored, out):
    """A model's point is (x - 1/2, y - 1/2, 1/2 - z) of its colour, times the scale; the quaternion is inverse."""
    for view in Dataset.open(stored).views():
        stem, camera, geometry = f"{view.number:04d}", view.camera(), view.geometry()
        picture: Any = cv2.imread(str(out / f"{stem}_coord.png"))
        colours = picture[..., ::-1] / 255.0
        mask = instances(out / f"{stem}_mask.exr")
        for row, label in zip(load_meta(out / f"{stem}_meta.txt"), view.labels().objects, strict=True):
            rotation = turned(*row["quaternion"]).T
            np.testing.assert_allclose(row["translation"], np.array(label.camera_T_object)[:3, 3], atol=1e-6)
            up = rotation @ [0.0, 1.0, 0.0]  # models are y up
            np.testing.assert_allclose(up, np.array(label.camera_T_object)[:3, 2], atol=1e-6)
            on = mask == row["index"]
            model = row["scale"] * (np.where([True, True, False], colours[on], 1.0 - colours[on]) - 0.5)
            points = model @ rotation.T + row["translation"]
            v, u = np.nonzero(on)
            rays = np.column_stack([u, v, np.ones(len(u))]) @ np.linalg.inv(camera.K).T
            step = row["scale"] / 255.0  # of a colour with 8 bits
            np.testing.assert_allclose(points, rays * geometry.Z[on][:, None], atol=step)
