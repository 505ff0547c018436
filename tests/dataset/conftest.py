from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import pytest

from glassware.annotate.keypoints import scene_keypoints
from glassware.annotate.labels import Labels, annotate
from glassware.dataset.depth_cameras.measure import REASONS
from glassware.dataset.format.camera_file import PolarisationRecord, depth_camera_record
from glassware.dataset.format.dataset_file import DatasetFile, installed_versions
from glassware.dataset.format.file_kinds import EARLIER_KINDS
from glassware.dataset.format.pictures import write_png
from glassware.dataset.format.polarisation_files import polarisation_numbers, read_stokes, write_stokes
from glassware.dataset.pipeline import write
from glassware.dataset.polarisation_cameras.mosaic import reported
from glassware.dataset.reader import Dataset
from glassware.dataset.settings.draw import draw
from glassware.dataset.writer import finish_dataset, scene_writer, start_dataset
from glassware.procedural.description.depth_camera import DepthCamera
from glassware.procedural.sensors.depth_cameras import depth_camera
from glassware.procedural.sensors.polarisation_cameras import polarisation_camera
from glassware.render.frame import Frame, StokesPicture

#: Name of a depth camera, whose depth is in millimetres.
DEVICE = "d435"
#: One view of two vessels, one of them filled, and two props.
SEED = 11
SETTINGS = {
    "vessel_count": [2, 2],
    "prop_count": [2, 2],
    "vessels": {"categories": ["tumbler", "beaker"], "chord_error": 1e-4, "fill_probability": 1.0},
    "props": {"kinds": ["shape"]},
    "physics": {"piled_probability": 0.0},
    "cameras": {"width": 40, "height": 30, "views": 1},
    "picture": {"spp": 2, "denoise": False},
}


class Rendered(NamedTuple):
    """A view as it is written."""

    frame: Frame
    labels: Labels


@pytest.fixture(scope="session")
def write_scene() -> Callable[..., None]:
    """(root, scene, points, views) -> nothing: the views are written one by one, as they are asked for."""

    def write(root, scene, points, views: Iterable[Rendered]) -> None:
        with scene_writer(root, scene, points, files=EARLIER_KINDS) as writer:
            for frame, labels in views:
                writer.add(frame, labels)

    return write


@pytest.fixture(scope="session")
def made(analytic):
    """The closed-form scene, its keypoints, and its rendered and labelled views."""
    scene = analytic.scene(views=2)
    points = scene_keypoints(scene)
    views = []
    for camera in scene.cameras:
        frame = analytic.frame(scene, camera)
        sight = analytic.sight(scene, camera, points.world.reshape(-1, 3))
        views.append(Rendered(frame, annotate(scene, camera, frame.geometry, points, sight)))
    return scene, points, views


@pytest.fixture
def head():
    return DatasetFile(name="test", seed=7, config={"spp": 4}, versions=installed_versions(), backend="llvm_ad_rgb")


@pytest.fixture
def stored(made, head, write_scene, tmp_path):
    """A finished data set of that scene."""
    scene, points, views = made
    root = tmp_path / "data"
    start_dataset(root, head, [scene.scene_id])
    write_scene(root, scene, points, views)
    finish_dataset(root)
    return root


@pytest.fixture(scope="session")
def proven(made_once, backend) -> Path:
    """A data set of one view with all files; do not change it."""
    return made_once("proven", lambda folder: write(folder / "data", draw(SEED, 0, **SETTINGS), files="all")) / "data"


@pytest.fixture
def copy(proven, tmp_path) -> Path:
    """A copy of it."""
    return Path(shutil.copytree(proven, tmp_path / "data"))


@pytest.fixture(scope="session")
def add_sensor_depth() -> Callable[[Path], Path]:
    """(root) -> root: give each view of a data set a depth camera's depth, with a hole every fifth row."""
    device = depth_camera(DEVICE, "device")
    assert isinstance(device, DepthCamera)
    assert device.unit == 1e-3
    record = depth_camera_record(device, 1e-2, 1.0, REASONS).model_dump(mode="json")

    def add(root: Path) -> Path:
        for view in Dataset.open(root).views():
            Z = view.geometry().Z
            steps = np.where(np.isfinite(Z) & (Z < 60.0), np.rint(1000.0 * Z), 0.0).astype(np.uint16)
            steps[::5] = 0
            cv2.imwrite(str(view.folder / "sensor_depth.png"), steps)
            cv2.imwrite(str(view.folder / "sensor_valid.png"), np.where(steps > 0, 1, 2).astype(np.uint16))
            camera = view.folder / "camera.json"
            camera.write_text(json.dumps(json.loads(camera.read_text()) | {"depth_camera": record}))
        return root

    return add


@pytest.fixture(scope="session")
def add_sensors(add_sensor_depth) -> Callable[[Path], Path]:
    """(root) -> root: give each view of a data set the files of a depth camera and of a polarisation camera."""
    device = polarisation_camera("imx250mzr")
    assert device is not None
    names = ("name", "angles", "colour", "extinction_ratio", "bits", "black_level")
    record = PolarisationRecord(gain=0.5, **{name: getattr(device, name) for name in names})

    def add(root: Path) -> Path:
        for view in Dataset.open(add_sensor_depth(root)).views():
            rng, shape = np.random.default_rng(view.number), view.geometry().Z.shape
            depth = cv2.imread(str(view.folder / "sensor_depth.png"), cv2.IMREAD_UNCHANGED)
            assert depth is not None
            write_png(view.folder / "sensor_valid.png", np.where(depth > 0, 1, 2).astype(np.uint16))
            for name in ("ir_left.png", "ir_right.png"):
                write_png(view.folder / name, rng.integers(0, 255, (480, 848)).astype(np.uint16))
            vector = rng.uniform(-0.3, 0.3, (*shape, 4, 3)).astype(np.float32)
            vector[..., 0, :] = rng.uniform(0.6, 1.0, (*shape, 3))
            write_stokes(view.folder / "stokes.exr", StokesPicture(vector, np.zeros((*shape, 4), np.float32)), 1.0)
            vector = read_stokes(view.folder / "stokes.exr").vector
            for name, numbers in zip(("dolp.png", "aolp.png"), polarisation_numbers(vector), strict=True):
                write_png(view.folder / name, numbers)
            write_png(view.folder / "polarisation_mosaic.png", reported(device, vector, record.gain, rng))
            camera = view.folder / "camera.json"
            more = {"polarisation_camera": record.model_dump(mode="json")}
            camera.write_text(json.dumps(json.loads(camera.read_text()) | more))
        return root

    return add
