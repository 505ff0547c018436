"""Fields at 1/8 of the image size: the object that each cell belongs to, and the encoded box of that object."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...annotate.heatmap import HEAT_THRESHOLD, Gaussian, log_heat, peak_pixel
from ...annotate.projection import project_camera
from .encoding import Encoding, encoded_covariance, encoded_depth, encoded_vertices
from .objects import ViewObject

#: Pixels between two cells; cell (i, j) stands for the pixel in row 8 i and column 8 j.
STRIDE = 8


def cell_owners(gaussians: list[Gaussian], size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return the object that each cell belongs to.

    A cell belongs to the object with the greatest heat at its pixel, the first one of equals. The cell nearest to the
    peak of an object, from which its box is decoded, belongs to that object. Where several objects share that cell, it
    belongs to the one whose peak is nearest to the cell's pixel, and the others are lost at this resolution.

    Parameters
    ----------
    gaussians : list of Gaussian
        Of n > 0 objects.
    size : (int, int)
        Height and width of the image [px], multiples of 8.

    Returns
    -------
    owner : (H/8, W/8) int
        Index of the object.
    cell_mask : (H/8, W/8) bool
        Cells with a target: those with a heat above `HEAT_THRESHOLD`, and those at peaks.
    """
    heat = log_heat(gaussians, size, STRIDE)
    owner, cell_mask = heat.argmax(0), heat.max(0) > np.log(HEAT_THRESHOLD)
    peaks = np.stack([peak_pixel(gaussian, size) for gaussian in gaussians])
    cells = peak_cells(peaks, owner.shape)
    distance = np.linalg.norm(cells * STRIDE - peaks, axis=1)
    for index in np.argsort(-distance, kind="stable"):  # the nearest is written last
        column, row = cells[index]
        owner[row, column], cell_mask[row, column] = index, True
    return owner, cell_mask


def peak_cells(peaks: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Return the nearest cells (column, row) of peaks (x, y), (n, 2) int [px]."""
    limit = np.array([shape[1] - 1, shape[0] - 1])
    return np.clip(np.rint(peaks / STRIDE), 0, limit).astype(np.int64)


def box_covariance(camera_T_object: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return the covariance of a uniform density in boxes, camera axes, (..., 3, 3) [m^2].

    R diag(s^2 / 12) R^T of the rotation R and the size s. Its axes are those of the box; those of mesh vertices would
    not be.
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
    """Return ``vertex`` (16, h, w), ``z_centroid`` (h, w), ``covariance`` (6, h, w), float32, of each cell's owner.

    Parameters
    ----------
    objects : sequence of ViewObject
        Objects with every corner in front of the camera.
    owner : (h, w) int
        From `cell_owners`.
    K : (3, 3) float
        Intrinsic matrix [px].
    size : (int, int)
        Height and width of the image [px].
    encoding : Encoding
        Encoding of the fields.
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
