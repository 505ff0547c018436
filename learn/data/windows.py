"""Windows: parts of pictures, with the cameras and the labels that belong to them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...annotate.projection import project, transformed
from ...core.errors import InputError
from ...dataset.format.camera_file import CameraFile, known_K
from ..networks.settings import SIZE_MULTIPLE
from .ground_truth import GroundTruth
from .views import CameraView


@dataclass(frozen=True)
class Window:
    """A part of a picture."""

    rows: slice
    columns: slice

    @property
    def slices(self) -> tuple[slice, slice]:
        """The rows and the columns."""
        return self.rows, self.columns

    @property
    def size(self) -> tuple[int, int]:
        """Height and width [px]."""
        return self.rows.stop - self.rows.start, self.columns.stop - self.columns.start


def whole_picture(size: tuple[int, int]) -> Window:
    """Return all of a picture of a height and a width [px]."""
    return Window(slice(0, size[0]), slice(0, size[1]))


def cut(view: CameraView, window: Window) -> CameraView:
    """Return a window of a view; its camera's principal point moves by the window's corner."""
    picture = np.ascontiguousarray(view.picture[window.slices])
    return CameraView(picture, view.world_T_camera, windowed_K(view.K, window))


def windowed_K(K: np.ndarray, window: Window) -> np.ndarray:
    """Return the intrinsic matrix of a window."""
    moved = K.copy()
    moved[0, 2] -= window.columns.start
    moved[1, 2] -= window.rows.start
    return moved


def cut_labels(labels: GroundTruth, window: Window) -> GroundTruth:
    """Return the labels of a window; objects outside of it have no visible pixel."""
    if window.size == labels.Z.shape:
        return labels  # also where no map says which pixels are an object's
    instances, Z = (np.ascontiguousarray(values[window.slices]) for values in (labels.instances, labels.Z))
    objects = tuple(replace(item, visible=int((instances == item.id).sum())) for item in labels.objects)
    return replace(labels, instances=instances, Z=Z, objects=objects)


def window_of_source(reference: CameraView, window: Window, source: CameraView, depth: float) -> Window:
    """Return the window of another view that shows what a window of the reference shows at a depth.

    Of a pair, at the same place a window of the right eye misses the left part of what the left one shows, as wide as
    the disparity; nothing is matched there. Moved by the disparity of the middle depth both windows show the same.

    Parameters
    ----------
    reference, source : CameraView
        The views.
    window : Window
        Of the reference.
    depth : float
        Depth in the reference at which the middles of both windows meet [m].
    """
    u, v = (0.5 * (part.start + part.stop - 1) for part in (window.columns, window.rows))
    point = depth * np.linalg.solve(reference.K, np.array([u, v, 1.0]))
    ((x, y),), (Z,) = project(transformed(reference.world_T_camera, point[None]), source.K, source.world_T_camera)
    if Z <= 0.0:
        return window
    height, width = source.picture.shape[:2]
    return Window(_moved(window.rows, y, height), _moved(window.columns, x, width))


def stored_windows(camera: CameraFile, convergence: float | None, where: Path | str) -> tuple[Window, Window]:
    """Return the parts of the reference's picture and of the others that are used: all, or what both eyes see.

    Parameters
    ----------
    camera : CameraFile
        Of the stored pictures; a rectified pair where `convergence` is set.
    convergence : float, optional
        Depth at which both eyes are to show the same [m] (`ViewSettings.convergence`).
    where : Path or str
        What errors call it.

    Raises
    ------
    InputError
        Where hardly anything is left.
    """
    size = camera.height, camera.width
    if convergence is None:
        return whole_picture(size), whole_picture(size)
    disparity = known_K(camera, where)[0][0] * (camera.baseline or 0.0) / convergence
    if disparity > size[1] - SIZE_MULTIPLE:
        found = f"{convergence:g}, where one eye alone sees {disparity:.0f} of the {size[1]} px of {where}"
        raise InputError("views.convergence", "a depth at which both eyes see the same [m]", found)
    return shared_windows(size, disparity)


def shared_windows(size: tuple[int, int], disparity: float) -> tuple[Window, Window]:
    """Return the parts of a rectified pair's left and right picture that show the same at a disparity.

    The left eye alone sees a strip at its left, as wide as the disparity, and the right one a strip at its right. What
    is left are pictures of cameras whose principal points are moved apart; there the disparity is 0.

    Parameters
    ----------
    size : (int, int)
        Height and width of both pictures [px].
    disparity : float
        Focal length times baseline over depth [px].
    """
    height, width = size
    strip = round(disparity)
    return Window(slice(0, height), slice(strip, width)), Window(slice(0, height), slice(0, width - strip))


def _moved(part: slice, middle: float, side: int) -> slice:
    """Return a part of a side with another middle, as far as the side goes."""
    length = part.stop - part.start
    start = round(min(max(middle - 0.5 * (length - 1), 0.0), side - length))
    return slice(start, start + length)
