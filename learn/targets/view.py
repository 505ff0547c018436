"""All training targets of one view."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...annotate.heatmap import Gaussian, gaussian_of, heatmap, is_detectable
from ...procedural.description.scene import TABLE_ID
from .encoding import Encoding
from .fields import STRIDE, cell_owners, object_fields
from .objects import ViewObject

#: Semantic classes of pixels.
BACKGROUND, TABLE, TRANSPARENT, OPAQUE = range(4)


def detectable(objects: Sequence[ViewObject]) -> list[ViewObject]:
    """Return the objects that a network is to detect (`annotate.heatmap.is_detectable`)."""
    return [item for item in objects if is_detectable(item.visible, item.corners)]


def view_targets(
    instances: np.ndarray, Z: np.ndarray, objects: Sequence[ViewObject], K: np.ndarray, encoding: Encoding
) -> dict[str, np.ndarray]:
    """Return the training targets of a view.

    Parameters
    ----------
    instances : (H, W) integer
        Instance ids of the first surface.
    Z : (H, W) float
        Planar depth of the first surface [m]; +inf for none.
    objects : sequence of ViewObject
        All objects of the scene.
    K : (3, 3) float
        Intrinsic matrix [px].
    encoding : Encoding
        Encoding of the fields.

    Returns
    -------
    dict of arrays
        ``depth`` (H, W) float32 [m], 0 for none. ``seg`` (H, W) int64, the class of each pixel. ``heatmap`` (H, W)
        float32. ``vertex``, ``z_centroid`` and ``covariance`` at 1/8 of the image size, and ``cell_mask`` bool, their
        cells with a target. ``offset`` (2, H, W) float32, from a pixel (right, down) to the mean of the visible pixels
        of its object, divided by H; 0 where ``object_mask`` (H, W) bool is false: outside of the detectable objects.
    """
    size = (Z.shape[0], Z.shape[1])
    wanted = detectable(objects)
    gaussians = [gaussian_of(instances == item.id) for item in wanted]
    targets = {
        "depth": np.where(np.isfinite(Z), Z, 0.0).astype(np.float32),
        "seg": semantic(instances, objects),
        "heatmap": heatmap(gaussians, size),
        **_offsets(instances, wanted, gaussians),
    }
    if wanted:
        owner, cell_mask = cell_owners(gaussians, size)
        return {**targets, "cell_mask": cell_mask, **object_fields(wanted, owner, K, size, encoding)}
    cells = (size[0] // STRIDE, size[1] // STRIDE)
    shapes = {"vertex": (16, *cells), "covariance": (6, *cells), "z_centroid": cells}
    zeros = {name: np.zeros(shape, np.float32) for name, shape in shapes.items()}
    return {**targets, **zeros, "cell_mask": np.zeros(cells, bool)}


def semantic(instances: np.ndarray, objects: Sequence[ViewObject]) -> np.ndarray:
    """Return the semantic class of the first surface of each pixel, (H, W) int64."""
    class_of = np.full(int(instances.max(initial=0)) + 1, BACKGROUND, np.int64)
    class_of[TABLE_ID : TABLE_ID + 1] = TABLE
    for item in objects:
        class_of[item.id : item.id + 1] = TRANSPARENT if item.transparent else OPAQUE
    return class_of[instances]


def _offsets(instances: np.ndarray, wanted: list[ViewObject], gaussians: list[Gaussian]) -> dict[str, np.ndarray]:
    height, width = instances.shape
    offset, object_mask = np.zeros((2, height, width), np.float32), np.zeros((height, width), bool)
    for item, gaussian in zip(wanted, gaussians, strict=True):
        y, x = np.nonzero(instances == item.id)
        offset[:, y, x] = ((gaussian.mean[:, None] - np.stack([x, y])) / height).astype(np.float32)
        object_mask[y, x] = True
    return {"offset": offset, "object_mask": object_mask}
