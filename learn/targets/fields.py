"""Fields at an eighth of the picture's size: which object each cell belongs to, and what it says of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...annotate.projection import project_camera
from .encoding import Encoding, encoded_covariance, encoded_depth, encoded_vertices
from .heatmap import THRESHOLD, Normal, hottest_pixel, log_heat
from .objects import ViewObject

#: Pixels between two cells; cell (i, j) stands for the pixel in row 8 i and column 8 j.
STRIDE = 8


def owners(normals: list[Normal], size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return which object each cell belongs to.

    A cell belongs to the object of the greatest heat at its pixel; the first one wins a tie. The cell that is read for
    an object, next to its peak, belongs to that object. Where several are read from one cell, the one whose peak is
    nearest to the cell's pixel has it, and the others cannot be told apart from it at this size.

    Parameters
    ----------
    normals : list of Normal
        Of n > 0 objects.
    size : (int, int)
        Height and width of the picture [px], multiples of 8.

    Returns
    -------
    owner : (H/8, W/8) int
        Index of the object.
    counts : (H/8, W/8) bool
        Cells that say something: those with a heat over `THRESHOLD` and those that are read.
    """
    heat = log_heat(normals, size, STRIDE)
    owner, counts = heat.argmax(0), heat.max(0) > np.log(THRESHOLD)
    peaks = np.stack([hottest_pixel(normal, size) for normal in normals])
    cells = peak_cells(peaks, owner.shape)
    away = np.linalg.norm(cells * STRIDE - peaks, axis=1)
    for index in np.argsort(-away, kind="stable"):  # the nearest is written last
        column, row = cells[index]
        owner[row, column], counts[row, column] = index, True
    return owner, counts


def peak_cells(peaks: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Return the cells (column, row) that are read for peaks (x, y), (n, 2) int [px]: the nearest."""
    limit = np.array([shape[1] - 1, shape[0] - 1])
    return np.clip(np.rint(peaks / STRIDE), 0, limit).astype(np.int64)


def box_covariance(camera_T_object: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return the covariance of a uniform density in boxes, camera axes, (..., 3, 3) [m^2].

    R diag(s^2 / 12) R^T of the rotation R and the size s. Its axes are the box's, which those of a mesh's vertices are
    not.
    """
    R = camera_T_object[..., :3, :3]
    return (R * (np.asarray(size)[..., None, :] ** 2 / 12.0)) @ np.swapaxes(R, -1, -2)


def object_fields(
    objects: Sequence[ViewObject],
    owner: np.ndarray,
    K: np.ndarray,
    size: tuple[int, int],
    encoding: Encoding,
) -> dict[str, np.ndarray]:
    """Return ``vertex`` (16, h, w), ``z_centroid`` (h, w), ``covariance`` (6, h, w), float32: each cell's owner's.

    Parameters
    ----------
    objects : sequence of ViewObject
        Objects with every corner before the camera.
    owner : (h, w) int
        From `owners`.
    K : (3, 3) float
        Intrinsic matrix [px].
    size : (int, int)
        Height and width of the picture [px].
    encoding : Encoding
        Units and order.
    """
    vertices = np.stack([project_camera(item.corners, K)[0] for item in objects])
    poses, sizes = np.stack([item.camera_T_object for item in objects]), np.stack([item.size for item in objects])
    covariance = encoded_covariance(box_covariance(poses, sizes), encoding)
    depth = encoded_depth(poses[:, 2, 3], encoding)
    row, column = np.indices(owner.shape)
    at = np.stack([column, row], axis=-1).reshape(-1, 2) * float(STRIDE)
    index = owner.reshape(-1)
    vertex = encoded_vertices(vertices[index], at, size, encoding)
    return {
        "vertex": vertex.T.reshape(16, *owner.shape).astype(np.float32),
        "z_centroid": depth[owner].astype(np.float32),
        "covariance": np.moveaxis(covariance[owner], -1, 0).astype(np.float32),
    }
