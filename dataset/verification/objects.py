"""The labels of objects in one eye: poses, boxes, counts, fractions, keypoints, order."""

from __future__ import annotations

import numpy as np

from ...annotate.labels import Labels
from ...core.mesh import Mesh
from ...procedural.description.scene import Prop, Scene, SceneObject
from ...render.frame import Geometry
from .fault import Fault, unlike
from .pinhole import Pinhole, image_of, in_picture, rays_of, seen_from
from .raycast import EDGE, cast
from .triangles import Triangles
from .truth import without_lamps

#: Labels are float64 all through, with poses of a few metres [m].
POSE = 1e-9
#: Image coordinates of a point some decimetres in front of a lens of some thousand pixels, from such poses [px].
PIXEL = 1e-5
#: Fractions may differ from the ratio of their counts by this (docs/format.md).
FRACTION = 2.0**-40
#: A surface this much in front of a keypoint certainly hides it, and one this little does not [m]: labels decide at
#: 0.1 mm.
HIDES, CLEARS = 1.5e-4, 0.5e-4


def object_list_faults(scene: Scene, labels: Labels, file: str) -> list[Fault]:
    """Check that the labels are of the scene's objects, in their order."""
    expected = [(item.id, item.name, item.category) for item in scene.objects]
    found = [(label.id, label.name, label.category) for label in labels.objects]
    return unlike("objects", file, "ids, names and categories", str(expected), str(found))


def pose_faults(scene: Scene, camera: Pinhole, labels: Labels, file: str) -> list[Fault]:
    """Compare poses, corners of 3D boxes and centroids with the description."""
    found: list[Fault] = []
    for item, label in zip(scene.objects, labels.objects, strict=True):
        where, pose = f"object {item.id}", np.asarray(item.world_T_object)
        local = np.eye(4)
        local[:3, :3], local[:3, 3] = camera.axes @ pose[:3, :3], seen_from(camera, pose[:3, 3])
        found += unlike("poses", file, f"{where} camera_T_object", local, label.camera_T_object, POSE)
        bits = np.arange(8)[:, None] >> np.arange(3) & 1
        corners = (bits - 0.5) * np.array(item.size) @ local[:3, :3].T + local[:3, 3]
        found += unlike("box3d", file, f"{where} box3d", corners, label.box3d, POSE)
        found += unlike("centroid", file, f"{where} centroid", local[:3, 3], label.centroid.point, POSE)
        pixel = image_of(camera, local[:3, 3])
        found += unlike("centroid", file, f"{where} centroid pixel", pixel, _pixel(label.centroid.pixel), PIXEL)
    return found


def amodal_box_faults(scene: Scene, camera: Pinhole, labels: Labels, file: str) -> list[Fault]:
    """Compare boxes around whole objects with the projections of their stored meshes."""
    found: list[Fault] = []
    width, height = camera.size
    for item, label in zip(scene.objects, labels.objects, strict=True):
        where, pose = f"object {item.id} box2d", np.asarray(item.world_T_object)
        points = np.concatenate([mesh.vertices for mesh in _outer_meshes(item)]).astype(np.float64)
        local = seen_from(camera, points @ pose[:3, :3].T + pose[:3, 3])
        if (local[:, 2] <= 0.0).any():
            found += unlike("boxes", file, f"{where}.amodal", None, label.box2d.amodal)
            continue
        pixels = image_of(camera, local)
        whole = np.concatenate([pixels.min(axis=0), pixels.max(axis=0)])
        found += unlike("boxes", file, f"{where}.amodal", whole, label.box2d.amodal or (), PIXEL)
        part = np.clip(whole, -0.5, np.array([width, height, width, height]) - 0.5)
        inside = part[0] < part[2] and part[1] < part[3]
        clipped = label.box2d.amodal_clipped
        found += unlike("boxes", file, f"{where}.amodal_clipped", part if inside else (), clipped or (), PIXEL)
    return found


def modal_box_faults(labels: Labels, geometry: Geometry, file: str) -> list[Fault]:
    """Compare boxes around visible pixels with the ids."""
    found: list[Fault] = []
    for label in labels.objects:
        visible = geometry.id == label.id
        rows, columns = np.flatnonzero(visible.any(axis=1)), np.flatnonzero(visible.any(axis=0))
        box = [columns.min() - 0.5, rows.min() - 0.5, columns.max() + 0.5, rows.max() + 0.5] if len(rows) else ()
        found += unlike("boxes", file, f"object {label.id} box2d.modal", box, label.box2d.modal or ())
    return found


def count_faults(labels: Labels, geometry: Geometry, file: str) -> list[Fault]:
    """Count the pixels of silhouettes again."""
    found: list[Fault] = []
    for label, crossed, reached in zip(labels.objects, geometry.crossed, geometry.reached, strict=True):
        visible = geometry.id == label.id
        counts = {
            "silhouette": np.count_nonzero(crossed),
            "visible": np.count_nonzero(crossed & visible),
            "seen_through": np.count_nonzero(reached & ~visible),
            "occluded": np.count_nonzero(crossed & ~reached),
        }
        for name, count in counts.items():
            found += unlike("counts", file, f"object {label.id} pixels.{name}", count, getattr(label.pixels, name))
    return found


def fraction_faults(labels: Labels, file: str) -> list[Fault]:
    """Check that fractions sum to exactly 1 and follow from the counts."""
    found: list[Fault] = []
    for label in labels.objects:
        where, whole = f"object {label.id} fractions", label.pixels.silhouette
        if whole == 0 or label.fractions is None:
            expected = None if whole == 0 else "three fractions"
            found += unlike("fractions", file, where, expected, label.fractions and str(label.fractions))
            continue
        values = label.fractions.model_dump()
        found += unlike("fractions", file, f"{where}, their sum", 1.0, sum(values.values()))
        for name, value in values.items():
            ratio = getattr(label.pixels, name) / whole
            found += unlike("fractions", file, f"{where}.{name}", ratio, value, 2.0 * FRACTION)
    return found


def order_faults(labels: Labels, geometry: Geometry, file: str) -> list[Fault]:
    """Count again where one object is in front of another one."""
    if labels.occlusion is None:
        return []  # as in data sets of earlier versions
    expected = {}
    for behind, crossed in zip(labels.objects, geometry.crossed, strict=True):
        counts = np.bincount(geometry.id[crossed])
        for front in labels.objects:
            if front.id != behind.id and front.id < len(counts) and counts[front.id]:
                expected[front.id, behind.id] = int(counts[front.id])
    found = {(pair.front, pair.behind): pair.pixels for pair in labels.occlusion}
    return unlike("occlusion", file, "occlusion", str(sorted(expected.items())), str(sorted(found.items())))


def keypoint_faults(
    keypoints: list[np.ndarray], scene: Scene, camera: Pinhole, labels: Labels, file: str
) -> list[Fault]:
    """Compare pixels and depths of keypoints, (k, 3) in object frames, and whether they are in the picture."""
    found: list[Fault] = []
    for item, label, points in zip(scene.objects, labels.objects, keypoints, strict=True):
        local = _local(item, camera, points)
        pixels = image_of(camera, local)
        inside = in_picture(camera, pixels)
        if len(label.keypoints) != len(points):
            found += unlike("keypoints", file, f"object {item.id}", len(points), len(label.keypoints))
            continue
        for number, keypoint in enumerate(label.keypoints):
            where = f"object {item.id} keypoint {number}"
            found += unlike("keypoints", file, f"{where} pixel", pixels[number], _pixel(keypoint.pixel), PIXEL)
            found += unlike("keypoints", file, f"{where} Z", local[number, 2], keypoint.Z, POSE)
            if (keypoint.state != "outside") != inside[number]:
                state = "another state than outside" if inside[number] else "outside"
                found.append(Fault("keypoint states", file, where, state, keypoint.state))
    return found


def keypoint_state_faults(
    triangles: Triangles, keypoints: list[np.ndarray], scene: Scene, camera: Pinhole, labels: Labels, file: str
) -> list[Fault]:
    """Trace rays to keypoints again: what is in front of each.

    Keypoints are vertices, so rays to them pass edges. Each is tried a little to four sides as well, and every state
    that one of the five finds is taken.
    """
    points = np.concatenate([_local(item, camera, p) for item, p in zip(scene.objects, keypoints, strict=True)])
    labelled = [
        (f"object {label.id} keypoint {number}", keypoint.state)
        for label in labels.objects
        for number, keypoint in enumerate(label.keypoints)
    ]
    pixels = image_of(camera, points)
    tried = np.flatnonzero(in_picture(camera, pixels))
    states = sight_states(triangles, camera, pixels[tried], points[tried, 2])
    names = ("visible", "through_glass", "occluded")
    found: list[Fault] = []
    for index, possible in zip(tried, states, strict=True):
        where, state = labelled[index]
        allowed = [name for name, ok in zip(names, possible, strict=True) if ok]
        if state not in [*allowed, "outside"]:  # `keypoint_faults` has those that should be outside, and are not
            found.append(Fault("keypoint states", file, where, " or ".join(allowed), state))
    return found


def sight_states(triangles: Triangles, camera: Pinhole, pixels: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """Return which states points may have, (n, 3) bool: nothing in front, only transparent surfaces, an opaque one.

    Parameters
    ----------
    triangles : Triangles
        The scene.
    camera : Pinhole
        The camera that looks.
    pixels : (n, 2) float
        Where the points are in its picture [px].
    depth : (n,) float
        Their planar depths [m].
    """
    steps = 2.0 * EDGE * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
    tries = len(steps)
    rays = (pixels[:, None] + steps).reshape(-1, 2)
    hits = without_lamps(triangles, cast(triangles, camera, rays))
    stretch = np.linalg.norm(rays_of(camera, rays), axis=1)
    possible = np.zeros((len(pixels), 3), bool)
    for margin in (HIDES, CLEARS):
        before = (np.repeat(depth, tries)[hits.ray] - hits.Z) * stretch[hits.ray] > margin
        opaque = triangles.opaque[hits.triangle]
        any_front, opaque_front = (np.zeros(len(rays), bool) for _ in range(2))
        any_front[hits.ray[before]] = True
        opaque_front[hits.ray[before & opaque]] = True
        for column, state in enumerate((~any_front, any_front & ~opaque_front, opaque_front)):
            possible[:, column] |= state.reshape(-1, tries).any(axis=1)
    return possible


def _local(item: SceneObject, camera: Pinhole, points: np.ndarray) -> np.ndarray:
    pose = np.asarray(item.world_T_object)
    return seen_from(camera, points @ pose[:3, :3].T + pose[:3, 3])


def _outer_meshes(item: SceneObject) -> list[Mesh]:
    return [item.mesh] if isinstance(item, Prop) else [part.mesh for part in item.interfaces]


def _pixel(pixel: tuple[float, float] | None) -> tuple[float, float]:
    return (np.nan, np.nan) if pixel is None else pixel
