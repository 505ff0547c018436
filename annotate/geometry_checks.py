"""Checks of per-pixel geometry: ids, background, normals, and the two cameras of a stereo pair against each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..procedural.description.camera import Camera
from ..procedural.description.scene import TABLE_ID, Scene
from ..procedural.description.surroundings import ROOM_IDS, RoomEnvironment
from ..render.frame import Geometry
from .projection import disparity, pixel_rays, unproject

#: Relative rounding difference of float32 depth between two walks along one ray: some steps of 2^-24.
DEPTH_TOLERANCE = 1e-6
#: Rounding of a float32 unit vector's length, after a rotation.
UNIT_TOLERANCE = 1e-5
#: Largest angle between a label's normal and the depth's own [rad]. Smooth shading of a tessellated surface turns the
#: normal from its facet's by up to half the angle between facets, and differences across a pixel do the rest.
NORMAL_TOLERANCE = np.deg2rad(10.0)
#: Largest angle between the surface to the left and right (above and below) of a pixel that still counts as smooth.
SMOOTH_TOLERANCE = np.deg2rad(10.0)
#: Steepest viewing angle at which finite differences give a normal [rad]: beyond it one pixel spans too much surface.
STEEPEST_VIEW = np.deg2rad(75.0)
#: Fraction of smooth pixels that may fail: creases that run within a pixel of the centre look smooth to differences.
OUTLIERS = 0.02
#: Disparity that interpolation between two pixels of the right view may miss on a curved surface [px].
DISPARITY_TOLERANCE = 0.05
#: Steps of disparity from a pixel of the left view to its neighbours beyond which it is on an edge [px].
DISPARITY_EDGE = 0.25
#: Largest fraction of pixels where the right camera may see a nearer part of the same object (a handle, a far wall).
HIDDEN = 0.1


@dataclass(frozen=True)
class Violation:
    """A contradiction between labels, geometry and description."""

    check: str  #: name of the check
    where: str  #: object, field or pixels
    expected: str
    found: str

    def __str__(self) -> str:
        return f"{self.check}: {self.where}: expected {self.expected}, found {self.found}"


def at_pixels(check: str, wrong: np.ndarray, expected: str, values: np.ndarray, where: str = "") -> list[Violation]:
    """Return one violation for all wrong pixels, (H, W) bool, with the first one's value; none where all are right."""
    rows, columns = np.nonzero(wrong)
    if not len(rows):
        return []
    place = f"{where} {len(rows)} px, first (u, v) = ({columns[0]}, {rows[0]})".strip()
    return [Violation(check, place, expected, str(values[rows[0], columns[0]]))]


def check_ids(scene: Scene, geometry: Geometry) -> list[Violation]:
    """Check ids against the scene, against depth, and against the silhouettes."""
    opaque = [TABLE_ID, *(prop.id for prop in scene.props), *_room_ids(scene)]
    known = [*opaque, *(vessel.id for vessel in scene.vessels)]
    found = [
        *at_pixels("ids", ~np.isin(geometry.id, [0, *known]), f"0 or one of {known}", geometry.id, "id"),
        *at_pixels(
            "ids", ~np.isin(geometry.background_id, [0, *opaque]), f"0 or one of {opaque}", geometry.background_id
        ),
        *at_pixels("ids", (geometry.id == 0) != np.isinf(geometry.Z), "id 0 where Z is infinite", geometry.id, "id"),
        *at_pixels(
            "ids",
            (geometry.background_id == 0) != np.isinf(geometry.background_Z),
            "background id 0 where its Z is infinite",
            geometry.background_id,
        ),
    ]
    for index, item in enumerate(scene.objects):
        visible, reached, crossed = geometry.id == item.id, geometry.reached[index], geometry.crossed[index]
        where = f"object {item.id}"
        found += at_pixels("ids", visible & ~reached, "a visible pixel to be reached", reached, where)
        found += at_pixels("ids", reached & ~crossed, "a reached pixel to be crossed", crossed, where)
    return found


def _room_ids(scene: Scene) -> list[int]:
    """Return the ids of a room's surfaces; none where the surroundings have no depth."""
    room = scene.environment
    return list(ROOM_IDS.values()) if isinstance(room, RoomEnvironment) and not room.at_infinity else []


def check_background(geometry: Geometry) -> list[Violation]:
    """Check that the background is never in front of the first surface, and equals it where it is opaque."""
    first, behind = geometry.Z, geometry.background_Z
    same = (geometry.id == geometry.background_id) & np.isfinite(first)
    step = np.subtract(behind, first, out=np.full(first.shape, np.inf), where=np.isfinite(first))
    inside = (geometry.transmittance >= 0.0) & (geometry.transmittance <= 1.0)
    return [
        *at_pixels("background", behind < first * (1.0 - DEPTH_TOLERANCE), "Z >= that of the first surface", behind),
        *at_pixels(
            "background",
            same & (np.abs(step) > first * DEPTH_TOLERANCE),
            "the first surface's Z where that is opaque",
            behind,
        ),
        *at_pixels("background", ~np.all(inside, axis=-1), "transmittance in [0, 1]", geometry.transmittance),
    ]


def check_normals(geometry: Geometry, K: np.ndarray) -> list[Violation]:
    """Check that normals have unit length and face the camera on surfaces, and are 0 elsewhere."""
    normal = geometry.normal.astype(np.float64)
    hit = np.isfinite(geometry.Z)
    length = np.linalg.norm(normal, axis=-1)
    facing = (normal * pixel_rays(hit.shape[0], hit.shape[1], K)).sum(axis=-1) <= UNIT_TOLERANCE
    return [
        *at_pixels("normals", hit & ~(np.abs(length - 1.0) <= UNIT_TOLERANCE), "length 1", length),
        *at_pixels("normals", ~hit & (length != 0.0), "0 where there is no surface", normal),
        *at_pixels("normals", hit & ~facing, "a normal that faces the camera", normal),
    ]


def check_normals_against_depth(geometry: Geometry, K: np.ndarray, opaque_ids: list[int]) -> list[Violation]:
    """Check normals against differences of depth, where the surface is smooth and opaque.

    A pixel counts where its four neighbours are on the same object, where the two differences across it agree in each
    direction, and where it is not seen at a grazing angle.
    """
    found = []
    estimate, smooth = _depth_normals(geometry, K)
    cosine = np.clip((estimate * geometry.normal[1:-1, 1:-1]).sum(axis=-1), -1.0, 1.0)
    for object_id in (TABLE_ID, *opaque_ids):
        counted = smooth & (geometry.id[1:-1, 1:-1] == object_id)
        wrong = counted & ~(np.arccos(cosine) <= NORMAL_TOLERANCE)
        if wrong.sum() > OUTLIERS * counted.sum():
            expected = f"normals within {np.rad2deg(NORMAL_TOLERANCE):.0f} degrees of the depth's"
            angle = np.pad(np.rad2deg(np.arccos(cosine)), 1)
            found += at_pixels("normals against depth", np.pad(wrong, 1), expected, angle, f"object {object_id}")
    return found


def check_disparity(left: Geometry, right: Geometry, camera: Camera) -> list[Violation]:
    """Check ``u_left - u_right = f b / Z`` against the right camera's own geometry.

    What the left camera sees at ``(u, v)`` stands at ``(u - f b / Z, v)`` in the right picture, with the same Z. There
    the right camera sees it, or something nearer, but never something farther. Between two pixels of the right picture
    anything between their disparities may be seen. Pixels that land out of the right picture do not count, nor do those
    on an edge: what is narrower than two pixels, such as a far glass's rim, may fall between the right view's rays.
    """
    height, width = left.Z.shape
    d_left = disparity(left.Z, camera.fx, camera.baseline)
    d_right = disparity(right.Z, camera.fx, camera.baseline)
    u = np.arange(width)[None, :] - d_left
    column = np.clip(np.floor(u).astype(int), 0, width - 2)
    row = np.arange(height)[:, None]
    near, far = d_right[row, column], d_right[row, column + 1]
    same = (right.id[row, column] == left.id) & (right.id[row, column + 1] == left.id)
    steepest = _steepest_step(d_left, left.id)
    counted = (u >= 0) & (u <= width - 1) & np.isfinite(left.Z) & (steepest < DISPARITY_EDGE)
    # Between two pixels with a crease, the surface stands out of the chord by up to a quarter of the change of slope.
    before, after = d_right[row, np.maximum(column - 1, 0)], d_right[row, np.minimum(column + 2, width - 1)]
    slack = DISPARITY_TOLERANCE + np.abs((near - before) - (after - far)) / 4.0 + np.where(counted, steepest, 0.0) / 2.0
    low, high = np.minimum(near, far) - slack, np.maximum(near, far) + slack
    farther = counted & (d_left > high)
    found = at_pixels("disparity", farther, "nothing farther in the right view", d_left - high)
    # Where both cameras see one object there, its own folds hide little: most pixels have to agree.
    differs = counted & same & ((d_left > high) | (d_left < low))
    if differs.sum() > HIDDEN * (counted & same).sum():
        found += at_pixels("disparity", differs, "f b / Z in both views", d_left)
    return found


def _steepest_step(values: np.ndarray, ids: np.ndarray) -> np.ndarray:
    """Return the larger step from each pixel to its left and right neighbours; +inf to another object or the border."""
    step = np.where(ids[:, 1:] == ids[:, :-1], np.abs(np.diff(values, axis=1)), np.inf)
    padded = np.pad(step, ((0, 0), (1, 1)), constant_values=np.inf)
    return np.maximum(padded[:, 1:], padded[:, :-1])


def _depth_normals(geometry: Geometry, K: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return normals from central differences, (H-2, W-2, 3), and where they can be trusted, (H-2, W-2) bool."""
    point = unproject(geometry.Z, K)
    centre = point[1:-1, 1:-1]
    before_u, after_u = centre - point[1:-1, :-2], point[1:-1, 2:] - centre
    before_v, after_v = centre - point[:-2, 1:-1], point[2:, 1:-1] - centre
    # In OpenCV axes the product of the steps along u and v points away from the camera.
    normal = -np.cross(before_u + after_u, before_v + after_v)
    with np.errstate(invalid="ignore", divide="ignore"):
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
        view = -(normal * centre).sum(axis=-1) / np.linalg.norm(centre, axis=-1)
        smooth = _aligned(before_u, after_u) & _aligned(before_v, after_v) & (view > np.cos(STEEPEST_VIEW))
    ids = geometry.id
    one = ids[1:-1, 1:-1]
    for other in (ids[1:-1, :-2], ids[1:-1, 2:], ids[:-2, 1:-1], ids[2:, 1:-1]):
        smooth &= one == other
    return normal, smooth


def _aligned(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    cosine = (a * b).sum(axis=-1) / (np.linalg.norm(a, axis=-1) * np.linalg.norm(b, axis=-1))
    return cosine > np.cos(SMOOTH_TOLERANCE)
