"""What is drawn on a picture in lines and points: boxes, axes, keypoints, silhouettes, mouths, fill lines."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import cv2
import numpy as np

from ...annotate.boxes import EDGES
from ...annotate.labels import Labels, ObjectLabel
from ...annotate.masks import decode_mask
from ...annotate.projection import project_camera
from ...procedural.description.camera import Camera
from ..reader import StoredView

#: Digits behind the point of image coordinates [px]: a hundredth of a pixel.
_DIGITS = 2
#: Farthest from the picture that a line is drawn [px]; browsers round larger coordinates.
_FARTHEST = 1e5


def view_shapes(labels: Labels, camera: Camera) -> list[dict[str, Any]]:
    """Return what is drawn of each object of one eye, as JSON records; coordinates are of the picture [px]."""
    return [_object(label, camera) for label in labels.objects]


def view_lines(view: StoredView) -> dict[str, list[list[list[float]]]]:
    """Return the mouths and fill lines of a view's vessels, polygons in the left picture [px]."""
    return {
        name: [pixel_lists(line) for lines in found.values() for line in lines if np.isfinite(line).all()]
        for name, found in (("openings", view.openings()), ("fill lines", view.fill_lines()))
    }


def _object(label: ObjectLabel, camera: Camera) -> dict[str, Any]:
    mask = decode_mask(label.mask_amodal.counts, label.mask_amodal.size)
    return {
        "id": label.id,
        "modal": box_sides(label.box2d.modal),
        "amodal": box_sides(label.box2d.amodal),
        "edges": segments(np.array(label.box3d), EDGES, camera.K),
        "axes": _axes(label, camera),
        "keypoints": [[*pixel_lists([p.pixel])[0], p.state] for p in label.keypoints if p.pixel is not None],
        "centre": None if label.centroid.pixel is None else pixel_lists([label.centroid.pixel])[0],
        "silhouette": _outlines(mask),
        "fractions": None if label.fractions is None else label.fractions.model_dump(mode="json"),
    }


def box_sides(box: tuple[float, ...] | None) -> list[float] | None:
    """Return the sides of a box to a hundredth of a pixel."""
    return None if box is None else [round(float(side), _DIGITS) for side in box]


def _axes(label: ObjectLabel, camera: Camera) -> list[list[list[float]]]:
    corners = np.array(label.box3d)
    length = 0.5 * np.linalg.norm(corners[7] - corners[0]) / np.sqrt(3.0)
    ends = label.camera_T_object[:3, 3] + length * np.vstack([np.zeros(3), label.camera_T_object[:3, :3].T])
    return segments(ends, ((0, 1), (0, 2), (0, 3)), camera.K)


def segments(points: np.ndarray, pairs: Iterable[tuple[int, int]], K: np.ndarray) -> list[list[list[float]]]:
    """Return lines between points of the camera frame, (n, 3); none where one is behind the camera."""
    pixels, Z = project_camera(points, K)
    if (Z <= 0.0).any():
        return []
    return [pixel_lists([pixels[a], pixels[b]]) for a, b in pairs]


def _outlines(mask: np.ndarray) -> list[list[list[float]]]:
    """Return the outlines of a mask, holes included, through its outermost pixels."""
    lines, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    return [line[:, 0].tolist() for line in lines]


def pixel_lists(points: Iterable[Any]) -> list[list[float]]:
    """Return image coordinates to a hundredth of a pixel, bounded far outside of the picture."""
    return [[round(float(np.clip(value, -_FARTHEST, _FARTHEST)), _DIGITS) for value in point] for point in points]
