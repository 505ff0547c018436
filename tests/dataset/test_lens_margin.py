"""Scenes that are built with a camera whose lens distorts: the margin that it sees is rendered."""

from __future__ import annotations

import numpy as np
import pytest

import glassware as gw
from glassware.dataset.builds.rerender import rerendered
from glassware.dataset.commands.develop import main as develop
from glassware.dataset.format.dataset_file import read_head
from glassware.dataset.reader import Dataset
from glassware.procedural.description.picture import Picture
from glassware.procedural.primitives import scenes

WIDTH, HEIGHT = 96, 72


@pytest.fixture(scope="module")
def root(backend, tmp_path_factory):
    """A data set of one view of a grey board, by the webcam and with radiance."""
    view = scenes.camera((0.0, 0.0, 0.5), width=WIDTH, height=HEIGHT, exposure=0.6)
    picture = Picture(spp=4, denoise=False, light="path", layers=0, refraction=False, camera="webcam")
    folder = tmp_path_factory.mktemp("margin") / "data"
    gw.write(folder, scenes.scene([], [view], picture=picture), files=("radiance",))
    return folder


def test_a_picture_that_is_built_with_a_lens_has_no_lost_pixels_and_one_that_is_developed_later_has(root) -> None:
    built = Dataset.open(root).views()[0]
    assert built.camera_record().colour_camera == "webcam"
    assert built.camera_record().lost is None
    assert built.picture("left").shape == (HEIGHT, WIDTH, 3)
    assert min(built.picture(eye).min() for eye in ("left", "right")) > 0
    out = root.parent / "later"
    assert develop([str(root), "--camera", "webcam", "--out", str(out)]) == 0
    later = Dataset.open(out).views()[0]
    assert later.camera_record().lost is not None
    assert later.picture("left").min() == 0
    assert list(rerendered(out, read_head(out), 0, [0])) == []  # of radiance in halves, as it is stored


def test_radiance_and_labels_are_those_of_the_ideal_camera(root) -> None:
    view = Dataset.open(root).views()[0]
    scene = gw.load_scene(root / "scenes" / "000000" / "scene.json")
    ideal = scene.model_copy(update={"picture": scene.picture.model_copy(update={"camera": "ideal"})})
    frame = gw.Renderer(ideal).frame(0)
    assert np.array_equal(view.radiance("left"), frame.left.astype(np.float16).astype(np.float32))
    assert np.array_equal(view.geometry().Z, frame.geometry.Z)
    assert list(rerendered(root, read_head(root), 0, [0])) == []
