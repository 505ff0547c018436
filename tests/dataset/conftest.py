from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

import pytest

from glassware.annotate.keypoints import scene_keypoints
from glassware.annotate.labels import Labels, annotate
from glassware.dataset.format.dataset_file import DatasetFile, installed_versions
from glassware.dataset.writer import finish_dataset, scene_writer, start_dataset
from glassware.render.frame import Frame


class Rendered(NamedTuple):
    """A view as it is written."""

    frame: Frame
    labels: Labels


@pytest.fixture(scope="session")
def write_scene() -> Callable[..., None]:
    """(root, scene, points, views) -> nothing: the views are written one by one, as they are asked for."""

    def write(root, scene, points, views: Iterable[Rendered]) -> None:
        with scene_writer(root, scene, points) as writer:
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
