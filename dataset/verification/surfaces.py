"""Depth, ids, normals and silhouettes of one eye: against the stored meshes, and against each other."""

from __future__ import annotations

import numpy as np

from ...procedural.description.scene import Scene
from ...render.frame import Geometry
from .fault import Fault, at_pixels
from .pinhole import Pinhole
from .triangles import Triangles, opaque_ids, partly_opaque_ids
from .truth import Truth, facing_normals, silhouettes

#: Rounding of float32 depths, and of positions at some metres from the origin [m].
DEPTH = 3e-6
#: Largest difference of a shading normal [1]: float32 weights at the corners of long, thin triangles.
NORMAL = 5e-3
#: Length of a unit vector of halves, and its cosine with a ray.
UNIT = 1e-3
#: Relative rounding of float32 depth between two walks along one ray.
RELATIVE = 1e-6


def depth_faults(truth: Truth, geometry: Geometry, file: str) -> list[Fault]:
    """Compare the depth of the first surface with the meshes'."""
    return _depths("depth", truth, truth.first, geometry.Z, file)


def background_faults(truth: Truth, triangles: Triangles, geometry: Geometry, file: str) -> list[Fault]:
    """Compare depth and id of the first opaque surface with the meshes'."""
    ids = truth.of_hits(truth.background, triangles.id[truth.hits.triangle], 0)
    wrong = (ids != geometry.background_id) & ~truth.doubtful & ~truth.crowded
    return _depths("background", truth, truth.background, geometry.background_Z, file) or at_pixels(
        "background", file, wrong, ids, geometry.background_id
    )


def id_faults(truth: Truth, triangles: Triangles, geometry: Geometry, file: str) -> list[Fault]:
    """Compare the ids of the first surface with the meshes'."""
    ids = truth.of_hits(truth.first, triangles.id[truth.hits.triangle], 0)
    return at_pixels("ids", file, (ids != geometry.id) & ~truth.doubtful, ids, geometry.id)


def normal_faults(truth: Truth, triangles: Triangles, geometry: Geometry, file: str) -> list[Fault]:
    """Compare normals with those interpolated on the meshes."""
    normals = truth.of_hits(truth.first, facing_normals(truth, triangles), 0.0)
    away = np.linalg.norm(normals - geometry.normal, axis=-1)
    slanted = _cosine(truth.camera, normals) < NORMAL  # which side it faces is then a matter of rounding
    return at_pixels("normals", file, (away > NORMAL) & ~truth.doubtful & ~slanted, normals, geometry.normal)


def mask_faults(truth: Truth, triangles: Triangles, scene: Scene, geometry: Geometry, file: str) -> list[Fault]:
    """Compare each object's silhouette, and the part that nothing opaque hides, with the meshes'."""
    ids = [item.id for item in scene.objects]
    found: list[Fault] = []
    for name, masks, stored in zip(
        ("mask_amodal", "mask_seen"),
        silhouettes(truth, triangles, ids),
        (geometry.crossed, geometry.reached),
        strict=True,
    ):
        for number, expected, mask in zip(ids, masks, stored, strict=True):
            wrong = (expected != mask) & ~truth.doubtful & ~truth.crowded
            found += at_pixels(f"masks of object {number}, {name}", file, wrong, expected, mask)
    return found


def id_contradictions(scene: Scene, geometry: Geometry, file: str) -> list[Fault]:
    """Compare ids with the description and with depth."""
    opaque = opaque_ids(scene)
    known = [0, *opaque, *(vessel.id for vessel in scene.vessels)]
    ids, behind = geometry.id, geometry.background_id
    return [
        *at_pixels("ids", file, ~np.isin(ids, known), f"one of {known}", ids),
        *at_pixels("ids", file, (ids == 0) != np.isinf(geometry.Z), "0 where there is no depth", ids),
        *at_pixels("background", file, ~np.isin(behind, [0, *opaque]), f"one of {[0, *opaque]}", behind),
    ]


def background_contradictions(scene: Scene, geometry: Geometry, file: str) -> list[Fault]:
    """Compare the background with the first surface: behind it, and the same where that is opaque."""
    first, behind = geometry.Z, geometry.background_Z
    hit, empty = np.isfinite(first), geometry.background_id == 0
    opaque = hit & (geometry.id == geometry.background_id) & ~np.isin(geometry.id, partly_opaque_ids(scene))
    with np.errstate(invalid="ignore"):
        apart = np.abs(np.where(opaque, behind, first) - first) > first * RELATIVE
    return [
        *at_pixels("background", file, behind < first * (1.0 - RELATIVE), first, behind),
        *at_pixels("background", file, opaque & apart, first, behind),
        *at_pixels("background", file, empty != np.isinf(behind), "id 0 where there is no depth", behind),
    ]


def transmittance_faults(scene: Scene, geometry: Geometry, file: str) -> list[Fault]:
    """Check that transmittance is a fraction, and 1 where nothing transparent is in front of the background."""
    values = geometry.transmittance
    inside = _every((values >= 0.0) & (values <= 1.0))
    clear = (geometry.id == geometry.background_id) & (geometry.id > 0)
    clear &= ~np.isin(geometry.id, partly_opaque_ids(scene))
    return [
        *at_pixels("transmittance", file, ~inside, "a fraction", values),
        *at_pixels("transmittance", file, clear & ~_every(values == 1.0), "1 in front of all glass", values),
    ]


def normal_contradictions(camera: Pinhole, geometry: Geometry, file: str) -> list[Fault]:
    """Check that normals have unit length and face the camera on surfaces, and are 0 elsewhere."""
    normals = geometry.normal.astype(np.float64)
    hit, length = np.isfinite(geometry.Z), np.sqrt(np.einsum("hwi,hwi->hw", normals, normals))
    return [
        *at_pixels("normals", file, hit & ~(np.abs(length - 1.0) <= UNIT), "length 1", length),
        *at_pixels("normals", file, ~hit & (length != 0.0), "0 where there is no surface", normals),
        *at_pixels("normals", file, hit & (_cosine(camera, normals) < -UNIT), "one that faces the camera", normals),
    ]


def silhouette_contradictions(scene: Scene, geometry: Geometry, file: str) -> list[Fault]:
    """Check that visible pixels are seen, and seen ones are in the silhouette."""
    found: list[Fault] = []
    for item, crossed, reached in zip(scene.objects, geometry.crossed, geometry.reached, strict=True):
        check = f"masks of object {item.id}"
        found += at_pixels(check, file, (geometry.id == item.id) & ~reached, "a visible pixel in mask_seen", reached)
        found += at_pixels(check, file, reached & ~crossed, "a seen pixel in mask_amodal", crossed)
    return found


def _depths(check: str, truth: Truth, which: np.ndarray, stored: np.ndarray, file: str) -> list[Fault]:
    depth = truth.of_hits(which, truth.hits.Z, np.inf)
    slack = truth.of_hits(which, truth.hits.slack, 0.0) + DEPTH * (1.0 + np.where(which >= 0, depth, 0.0))
    both = np.isfinite(depth) & np.isfinite(stored)
    apart = np.abs(np.where(both, stored, 0.0) - np.where(both, depth, 0.0)) > slack
    sure = ~truth.doubtful & ~(truth.crowded & (which != truth.first))  # the first surface has nothing before it
    wrong = ((np.isfinite(depth) != np.isfinite(stored)) | (both & apart) | np.isnan(stored)) & sure
    return at_pixels(check, file, wrong, depth, stored)


def _every(flags: np.ndarray) -> np.ndarray:
    """Return where all three of (H, W, 3) bool hold; NumPy's own reduction takes several times as long."""
    return flags[..., 0] & flags[..., 1] & flags[..., 2]


def _cosine(camera: Pinhole, normals: np.ndarray) -> np.ndarray:
    """Return the cosine between normals, (H, W, 3), and the way back to the camera."""
    height, width = normals.shape[:2]
    x = (np.arange(width) - camera.centre[0]) / camera.focal[0]
    y = ((np.arange(height) - camera.centre[1]) / camera.focal[1])[:, None]
    return -(x * normals[..., 0] + y * normals[..., 1] + normals[..., 2]) / np.sqrt(1.0 + x * x + y * y)
