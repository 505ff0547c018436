from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from glassware.annotate.arrays import masks, points
from glassware.annotate.labels import Labels
from glassware.core.errors import InputError
from glassware.procedural.optics.catalogue import catalogue
from glassware.procedural.primitives.bodies import slab
from glassware.procedural.primitives.scenes import camera, scene
from glassware.render.frame import Frame, Geometry

#: Depth of the plane in the frames below [m].
DEPTH = 0.5


@pytest.fixture(scope="module")
def frame():
    """A frame by hand: a plane across the view, on which two objects are seen."""
    glass = catalogue()["fused silica"]
    bodies = [
        slab((0.01, 0.01, 0.01), glass, (x, 0.0, 0.1), id=2 + k, name=f"tile-{k}") for k, x in enumerate((0.0, 0.2))
    ]
    made = scene(bodies, [camera((0.0, -0.4, 0.3), width=8, height=6)])
    ids = np.zeros((6, 8), np.uint16)
    ids[2:4, 1:3], ids[2:4, 5:7] = 2, 3
    crossed = np.stack([ids == 2, ids > 1])
    Z = np.full((6, 8), DEPTH, np.float32)
    Z[0] = np.inf
    blank = np.zeros((6, 8, 3), np.float32)
    geometry = Geometry(Z, blank, ids, Z, ids, blank, crossed, np.stack([ids == 2, ids == 3]))
    return Frame(0, blank, blank, None, None, geometry, {}, scene=made)


def test_masks_are_named_after_the_objects(frame):
    ids = frame.geometry.id
    visible, silhouette, seen = (masks(frame, kind) for kind in ("visible", "silhouette", "seen"))
    assert list(visible) == list(silhouette) == ["tile-0", "tile-1"]
    np.testing.assert_array_equal(visible["tile-1"], ids == 3)
    np.testing.assert_array_equal(silhouette["tile-1"], ids > 1)
    np.testing.assert_array_equal(seen["tile-1"], ids == 3)


def test_points_lie_at_their_depth_and_in_the_world(frame):
    seen = points(frame)
    assert seen.shape == (40, 3)  # all pixels but the first row, which sees nothing
    np.testing.assert_allclose(seen[:, 2], DEPTH, rtol=1e-7)
    eye = frame.scene.cameras[0]
    # The middle pixels of the picture look along the optical axis.
    np.testing.assert_allclose(seen.reshape(5, 8, 3)[1:3, 3:5].mean((0, 1)), [0.0, 0.0, DEPTH], atol=1e-7)
    pose = eye.world_T_camera
    np.testing.assert_allclose(points(frame, "world"), seen @ pose[:3, :3].T + pose[:3, 3], atol=1e-12)


def _wrong(function: Any, *arguments: Any) -> Any:
    """Call a function with arguments that its types do not allow."""
    return function(*arguments)


@pytest.mark.parametrize(
    ("call", "line"),
    [
        (
            lambda f: _wrong(masks, f, "amodal"),
            "masks: kind: expected one of visible, seen, silhouette, found",
        ),
        (lambda f: _wrong(masks, "out"), "masks: view: expected a Frame or Labels, found 'out'"),
        (lambda f: masks(Labels(objects=()), "visible"), "masks: kind: expected seen or silhouette, which labels hold"),
        (lambda f: _wrong(points, f, "table"), "points: coordinates: expected 'camera' or 'world', found 'table'"),
        (lambda f: _wrong(points, None), "points: frame: expected a Frame, found None"),
    ],
)
def test_what_is_no_view_is_one_line(frame, call, line):
    with pytest.raises(InputError) as error:
        call(frame)
    assert str(error.value).startswith(line)
