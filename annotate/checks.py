"""Checks of a view's labels against its geometry, against the scene's description, and against each other.

Each check takes plain data and returns a list of violations, which is empty where the labels are correct. The checks of
the geometry alone are in `geometry_checks`. ``glassware verify --labels`` runs them on a stored data set.
"""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull

from ..procedural.description.camera import Camera
from ..procedural.description.scene import Scene
from ..procedural.props.mesh_files import MESH_SUFFIXES
from ..render.frame import Geometry
from .boxes import EDGES, box_corners, modal_box
from .geometry_checks import (
    Violation,
    check_background,
    check_disparity,
    check_ids,
    check_normals,
    check_normals_against_depth,
)
from .labels import Keypoint, Labels, Rle
from .masks import decode_mask
from .projection import inside_picture, project, project_camera, transformed

#: Geometry is float32 and labels are float64, so a pixel centre on the very edge of a silhouette may lie this far out
#: of the exact projection [px]: float32 keeps 24 bits of a picture some hundred pixels wide, and a world some metres.
PIXEL_TOLERANCE = 0.01
#: Labels are float64 all through, with poses of a few metres [m].
POSE_TOLERANCE = 1e-9
#: Largest distance of a keypoint's own pixel from a pixel whose centre meets the object [px]: a keypoint on the very
#: edge of a silhouette lies up to half a pixel from the nearest centre in each direction, and that centre may miss.
KEYPOINT_REACH = 1


def check_view(
    scene: Scene, camera: Camera, labels: Labels, geometry: Geometry, right: Geometry | None = None
) -> list[Violation]:
    """Run every check on one view; the check of the disparity needs the right camera's geometry as well."""
    if wrong := check_objects(scene, labels):
        return wrong  # the other checks go through objects and labels in pairs
    # Meshes from files may be coarse: their smooth normals differ from their facets' by more than the tolerance.
    smooth = [prop.id for prop in scene.props if prop.origin is None and not _is_mesh_file(prop.category)]
    found = [
        *check_ids(scene, geometry),
        *check_background(geometry),
        *check_normals(geometry, camera.K),
        *check_normals_against_depth(geometry, camera.K, smooth),
        *check_poses(scene, camera, labels),
        *check_masks(labels, geometry),
        *check_fractions(labels),
        *check_boxes(labels, geometry),
        *check_box3d(labels, camera),
        *check_keypoints(labels, camera, [item.id for item in scene.objects if item.origin is not None]),
    ]
    return found if right is None else [*found, *check_disparity(geometry, right, camera)]


def _is_mesh_file(category: str) -> bool:
    """Return whether a category is the name of a mesh file, as descriptions without an origin have it."""
    return Path(category).suffix.lower() in MESH_SUFFIXES


def check_objects(scene: Scene, labels: Labels) -> list[Violation]:
    """Check that the labels are of the scene's objects, in their order."""
    expected = [(item.id, item.name) for item in scene.objects]
    found = [(label.id, label.name) for label in labels.objects]
    return [] if found == expected else [Violation("objects", "labels", str(expected), str(found))]


def check_poses(scene: Scene, camera: Camera, labels: Labels) -> list[Violation]:
    """Check poses, box corners and centroids against the description, through the world frame and back."""
    found = []
    for item, label in zip(scene.objects, labels.objects, strict=True):
        where = f"object {label.id}"
        world_T_object = camera.world_T_camera @ label.camera_T_object
        found += _far(f"{where} camera_T_object", item.world_T_object, world_T_object)
        corners = transformed(camera.world_T_camera, np.array(label.box3d))
        found += _far(f"{where} box3d", transformed(item.world_T_object, box_corners(item.size)), corners)
        centre = transformed(camera.world_T_camera, np.array([label.centroid.point]))[0]
        found += _far(f"{where} centroid", item.world_T_object[:3, 3], centre)
        pixel = project(item.world_T_object[None, :3, 3], camera.K, camera.world_T_camera)[0][0]
        found += _far(f"{where} centroid pixel", pixel, _pixel(label.centroid.pixel), PIXEL_TOLERANCE)
    return found


def check_masks(labels: Labels, geometry: Geometry) -> list[Violation]:
    """Check masks and pixel counts against the geometry's ids and silhouettes."""
    found = []
    for index, label in enumerate(labels.objects):
        where = f"object {label.id}"
        crossed, reached = geometry.crossed[index], geometry.reached[index]
        for name, mask, rle in (("amodal", crossed, label.mask_amodal), ("seen", reached, label.mask_seen)):
            decoded = _decoded(rle, mask.shape)
            if decoded is None:
                found.append(Violation("masks", f"{where} mask_{name}", f"a mask of {mask.shape} px", str(rle.size)))
            elif wrong := int((decoded != mask).sum()):
                found.append(Violation("masks", f"{where} mask_{name}", "the geometry's mask", f"{wrong} px differ"))
        visible = geometry.id == label.id
        expected = (crossed.sum(), visible.sum(), (reached & ~visible).sum(), (crossed & ~reached).sum())
        pixels = label.pixels
        counts = (pixels.silhouette, pixels.visible, pixels.seen_through, pixels.occluded)
        if counts != tuple(int(n) for n in expected):
            found.append(Violation("masks", f"{where} pixels", str(tuple(int(n) for n in expected)), str(counts)))
    return found


def check_fractions(labels: Labels) -> list[Violation]:
    """Check that fractions sum to exactly 1 and agree with the pixel counts."""
    found = []
    for label in labels.objects:
        where, whole, fractions = f"object {label.id} fractions", label.pixels.silhouette, label.fractions
        if fractions is None or whole == 0:
            if (fractions is None) != (whole == 0):
                found.append(Violation("fractions", where, f"those of {whole} px", str(fractions)))
            continue
        values = (fractions.visible, fractions.seen_through, fractions.occluded)
        if sum(values) != 1.0:
            found.append(Violation("fractions", where, "a sum of exactly 1", repr(sum(values))))
        counts = (label.pixels.visible, label.pixels.seen_through, label.pixels.occluded)
        # A count is wrong by one pixel or more; half of one is far above any rounding.
        if any(abs(value * whole - count) > 0.5 for value, count in zip(values, counts, strict=True)):
            found.append(Violation("fractions", where, f"{counts} of {whole} px", str(values)))
    return found


def check_boxes(labels: Labels, geometry: Geometry) -> list[Violation]:
    """Check 2D boxes: modal on its pixels, silhouette in amodal, clipped in the picture."""
    found = []
    height, width = geometry.id.shape
    for index, label in enumerate(labels.objects):
        where, boxes = f"object {label.id} box2d", label.box2d
        modal = modal_box(geometry.id == label.id)
        if boxes.modal != modal:
            found.append(Violation("boxes", f"{where}.modal", str(modal), str(boxes.modal)))
        silhouette = modal_box(geometry.crossed[index])
        if silhouette is None or boxes.amodal is None:
            continue
        inner = np.add(silhouette, (0.5, 0.5, -0.5, -0.5))  # centres of the outermost pixels
        found += _outside(f"{where}.amodal", inner, boxes.amodal)
        found += _outside(f"{where}.amodal_clipped", inner, boxes.amodal_clipped)
        found += _outside(f"{where}.amodal_clipped", boxes.amodal_clipped, (-0.5, -0.5, width - 0.5, height - 0.5))
        found += _outside(f"{where}.amodal_clipped", boxes.amodal_clipped, boxes.amodal)
    return found


def check_box3d(labels: Labels, camera: Camera) -> list[Violation]:
    """Check that projected 3D boxes contain silhouettes and amodal boxes, and that they are boxes."""
    found = []
    for label in labels.objects:
        where, corners = f"object {label.id} box3d", np.array(label.box3d)
        edges = np.array([corners[b] - corners[a] for a, b in EDGES]).reshape(3, 4, 3)
        uneven = np.abs(edges - edges[:, :1]).max()
        skew = np.abs(np.triu(edges[:, 0] @ edges[:, 0].T, 1)).max()
        if max(uneven, skew) > POSE_TOLERANCE:
            found.append(Violation("box3d", where, "four equal, square edges each way", f"off by {max(uneven, skew)}"))
        pixels, Z = project_camera(corners, camera.K)
        if (Z <= 0.0).any():
            continue
        if label.box2d.amodal is not None:
            bounds = (*pixels.min(axis=0).tolist(), *pixels.max(axis=0).tolist())
            found += _outside(f"{where} around box2d.amodal", label.box2d.amodal, bounds)
        silhouette = _decoded(label.mask_amodal, (camera.height, camera.width))
        if silhouette is not None:
            found += _silhouette_in_box(silhouette, pixels, where)
    return found


def check_keypoints(labels: Labels, camera: Camera, from_files: Collection[int] = ()) -> list[Violation]:
    """Check that keypoints in the picture lie on the seen part of their object, and that all others are `outside`.

    Meshes from files, whose ids are given, may be thinner than a pixel, as strips that opacity leaves are: a keypoint
    on such a part may have no pixel near it, and has to lie where its object's pixels are, from border to border.
    """
    found = []
    for label in labels.objects:
        size = (camera.height, camera.width)
        crossed, seen = _decoded(label.mask_amodal, size), _decoded(label.mask_seen, size)
        if crossed is None or seen is None:
            continue  # `check_masks` reports it
        if label.id in from_files:
            crossed = seen = _spanned(crossed)
        crossed, seen = _widened(crossed), _widened(seen)
        for number, point in enumerate(label.keypoints):
            where = f"object {label.id} keypoint {number}"
            found += _keypoint(point, crossed if point.state == "occluded" else seen, where)
    return found


def _keypoint(point: Keypoint, mask: np.ndarray, where: str) -> list[Violation]:
    height, width = mask.shape
    pixel = _pixel(point.pixel)
    inside = point.Z > 0.0 and bool(inside_picture(pixel[None], width, height)[0])
    if (point.state != "outside") != inside:
        return [Violation("keypoints", where, "inside" if inside else "outside", point.state)]
    if not inside:
        return []
    column, row = np.floor(pixel + 0.5).astype(int)
    if mask[row, column]:
        return []
    return [Violation("keypoints", where, f"a {point.state} pixel of its object", str(point.pixel))]


def _silhouette_in_box(silhouette: np.ndarray, corners: np.ndarray, where: str) -> list[Violation]:
    """Check pixel centres of a silhouette against the convex hull of the projected corners."""
    rows, columns = np.nonzero(silhouette)
    if not len(rows):
        return []
    # Unit normals out of the hull's edges and their offsets: a point is inside where normal . point + offset <= 0.
    sides = ConvexHull(corners).equations
    beyond = (np.stack([columns, rows], axis=1) @ sides[:, :2].T + sides[:, 2]).max(axis=1)
    worst = int(beyond.argmax())
    if beyond[worst] <= PIXEL_TOLERANCE:
        return []
    pixel = f"({columns[worst]}, {rows[worst]}) is {beyond[worst]:.2f} px out"
    return [Violation("box3d", where, "the whole silhouette inside its projection", pixel)]


def _outside(
    where: str, inner: tuple[float, ...] | np.ndarray | None, outer: tuple[float, ...] | None
) -> list[Violation]:
    if inner is None or outer is None:
        return [Violation("boxes", where, "a box", "none")]
    sign = np.array([1.0, 1.0, -1.0, -1.0])
    if ((np.array(inner) - np.array(outer)) * sign >= -PIXEL_TOLERANCE).all():
        return []
    return [Violation("boxes", where, f"{tuple(np.array(inner).tolist())} inside", str(outer))]


def _far(where: str, expected: np.ndarray, found: np.ndarray, tolerance: float = POSE_TOLERANCE) -> list[Violation]:
    if np.allclose(found, expected, rtol=0.0, atol=tolerance, equal_nan=True):
        return []
    return [Violation("poses", where, str(np.asarray(expected).tolist()), str(np.asarray(found).tolist()))]


def _decoded(rle: Rle, shape: tuple[int, ...]) -> np.ndarray | None:
    """Return a mask, or None where it is damaged or has another shape, which `check_masks` reports."""
    try:
        return decode_mask(rle.counts, rle.size) if rle.size == shape else None
    except ValueError:
        return None


def _pixel(pixel: tuple[float, float] | None) -> np.ndarray:
    return np.full(2, np.nan) if pixel is None else np.array(pixel)


def _spanned(mask: np.ndarray) -> np.ndarray:
    """Return the rectangle from the first to the last row and column of a mask's pixels."""
    box = modal_box(mask)
    spanned = np.zeros_like(mask)
    if box is not None:
        left, top, right, bottom = (round(edge + 0.5) for edge in box)
        spanned[top:bottom, left:right] = True
    return spanned


def _widened(mask: np.ndarray) -> np.ndarray:
    """Return a mask grown by `KEYPOINT_REACH` pixels in every direction."""
    padded = np.pad(mask, KEYPOINT_REACH)
    height, width = mask.shape
    steps = range(2 * KEYPOINT_REACH + 1)
    return np.logical_or.reduce([padded[i : i + height, j : j + width] for i in steps for j in steps])
