from __future__ import annotations

import pytest

from glassware.annotate.keypoints import scene_keypoints
from glassware.annotate.labels import annotate
from glassware.dataset.format.dataset_file import DatasetFile, installed_versions
from glassware.dataset.writer import View, finish_dataset, start_dataset, write_scene


@pytest.fixture(scope="session")
def made(analytic):
    """The closed-form scene, its keypoints, and its rendered and labelled views."""
    scene = analytic.scene(views=2)
    points = scene_keypoints(scene)
    views = []
    for number, camera in enumerate(scene.cameras):
        frame = analytic.frame(scene, camera)
        sight = analytic.sight(scene, camera, points.world.reshape(-1, 3))
        views.append(View(number, frame, annotate(scene, camera, frame.geometry, points, sight)))
    return scene, points, views


@pytest.fixture
def head():
    return DatasetFile(name="test", seed=7, config={"spp": 4}, versions=installed_versions(), backend="llvm_ad_rgb")


@pytest.fixture
def stored(made, head, tmp_path):
    """A finished data set of that scene."""
    scene, points, views = made
    root = tmp_path / "data"
    start_dataset(root, head, [scene.scene_id])
    write_scene(root, scene, points, views)
    finish_dataset(root)
    return root
