"""All targets of one view."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...annotate.projection import project_camera
from .encoding import Encoding
from .fields import STRIDE, object_fields, owners
from .heatmap import Normal, heatmap, normal_of
from .objects import ViewObject

#: Classes of pixels.
NOTHING, TABLE, TRANSPARENT, OPAQUE = range(4)
#: Id of the table in ``instances.png``; objects have greater ones.
_TABLE_ID = 1
#: Fewest visible pixels of an object that is to be found: a quarter of a cell of the fields.
FEWEST_PIXELS = STRIDE * STRIDE // 4


def findable(objects: Sequence[ViewObject], K: np.ndarray) -> list[ViewObject]:
    """Return the objects that a network is to find: some pixels visible, and the whole box before the camera."""
    return [
        item
        for item in objects
        if item.visible >= FEWEST_PIXELS and bool((project_camera(item.corners, K)[1] > 0.0).all())
    ]


def view_targets(
    instances: np.ndarray, Z: np.ndarray, objects: Sequence[ViewObject], K: np.ndarray, encoding: Encoding
) -> dict[str, np.ndarray]:
    """Return what a network is to give for a view.

    Parameters
    ----------
    instances : (H, W) integer
        Ids of the first surface.
    Z : (H, W) float
        Planar depth of the first surface [m]; +inf for none.
    objects : sequence of ViewObject
        All objects of the scene.
    K : (3, 3) float
        Intrinsic matrix [px].
    encoding : Encoding
        Units and order of the fields.

    Returns
    -------
    dict of arrays
        ``depth`` (H, W) float32 [m], 0 for none. ``seg`` (H, W) int64, the class of each pixel. ``heatmap`` (H, W)
        float32. ``vertex``, ``z_centroid`` and ``covariance`` at an eighth of the size, and ``counts`` bool, the cells
        of them that a network is asked for. ``offset`` (2, H, W) float32, from a pixel (right, down) to the mean of its
        object's visible pixels, over H; 0 where ``owned`` (H, W) bool is false: where there is no object that is to be
        found.
    """
    size = (Z.shape[0], Z.shape[1])
    wanted = findable(objects, K)
    normals = [normal_of(instances == item.id) for item in wanted]
    targets = {
        "depth": np.where(np.isfinite(Z), Z, 0.0).astype(np.float32),
        "seg": semantic(instances, objects),
        "heatmap": heatmap(normals, size),
        **_offsets(instances, wanted, normals),
    }
    if wanted:
        owner, counts = owners(normals, size)
        return {**targets, "counts": counts, **object_fields(wanted, owner, K, size, encoding)}
    cells = (size[0] // STRIDE, size[1] // STRIDE)
    shapes = {"vertex": (16, *cells), "covariance": (6, *cells), "z_centroid": cells}
    nothing = {name: np.zeros(shape, np.float32) for name, shape in shapes.items()}
    return {**targets, **nothing, "counts": np.zeros(cells, bool)}


def semantic(instances: np.ndarray, objects: Sequence[ViewObject]) -> np.ndarray:
    """Return the class of each pixel's first surface, (H, W) int64."""
    table = np.full(int(instances.max(initial=0)) + 1, NOTHING, np.int64)
    table[_TABLE_ID : _TABLE_ID + 1] = TABLE
    for item in objects:
        table[item.id : item.id + 1] = TRANSPARENT if item.transparent else OPAQUE
    return table[instances]


def _offsets(instances: np.ndarray, wanted: list[ViewObject], normals: list[Normal]) -> dict[str, np.ndarray]:
    height, width = instances.shape
    offset, owned = np.zeros((2, height, width), np.float32), np.zeros((height, width), bool)
    for item, normal in zip(wanted, normals, strict=True):
        y, x = np.nonzero(instances == item.id)
        offset[:, y, x] = ((normal.mean[:, None] - np.stack([x, y])) / height).astype(np.float32)
        owned[y, x] = True
    return {"offset": offset, "owned": owned}
