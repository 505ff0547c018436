"""``camera.json`` and ``objects.json`` against the scene's description and its meshes."""

from __future__ import annotations

import numpy as np

from ...core.mesh import Mesh
from ...procedural.description.camera import Camera
from ...procedural.description.scene import Prop, Scene, SceneObject
from ...procedural.optics.medium import Medium
from ..format.camera_file import CameraFile
from ..format.objects_file import GlassMaterial, MediumRecord, ObjectRecord, ObjectsFile
from .fault import Fault, unlike
from .solids import CHORD, diagonal, meshes_of, solid_meshes, standing_in, triangles_of_meshes, worst_distance
from .symmetries import symmetry_faults

#: Float64 through JSON [m, px].
EXACT = 1e-12
#: Distance of a point from the surface that it is on [m]: float32 positions of some decimetres.
ON_SURFACE = 1e-6
#: Relative difference of volumes of meshes by two sums in float64 over float32 positions, and of a profile's frusta
#: from its 64 to some hundred facets.
VOLUME, FACETS = 1e-4, 0.02
#: Ranges of the constants of transparent media: refractive index at 587.56 nm from aerogel's to diamond's, Abbe number
#: of glasses and liquids (Schott and Ohara glass maps: 16 to 95), density from ether to dense flint [kg/m^3], surface
#: tension from ether's to mercury's [N/m].
RANGES = {
    "eta": (1.0, 2.5),
    "abbe": (10.0, 120.0),
    "density": (0.5, 8000.0),
    "surface_tension": (0.005, 0.5),
    "contact_angle": (0.0, np.pi),
}


def camera_faults(camera: Camera, record: CameraFile, file: str) -> list[Fault]:
    """Compare ``camera.json`` with the camera of the description, and the right camera's pose with the left one's."""
    cx, cy = camera.centre
    focal_y = camera.focal if camera.focal_y is None else camera.focal_y
    K = [[camera.focal, 0.0, cx], [0.0, focal_y, cy], [0.0, 0.0, 1.0]]
    pose = np.asarray(record.world_T_camera)
    right = pose.copy()
    right[:3, 3] += (record.baseline or 0.0) * pose[:3, 0]  # null: the baseline is a fault of its own
    return [
        *unlike("camera", file, "K", K, record.K, EXACT),
        *unlike("camera", file, "width and height", (camera.width, camera.height), (record.width, record.height)),
        *unlike("camera", file, "world_T_camera", camera.world_T_camera, pose, EXACT),
        *unlike("camera", file, "baseline", camera.baseline, record.baseline, EXACT),
        *unlike("camera", file, "world_T_right", right, record.world_T_right, EXACT),
        *unlike("camera", file, "exposure", camera.exposure, record.exposure, EXACT * camera.exposure),
        *rigid_faults("camera", file, "world_T_camera", pose),
    ]


def rigid_faults(check: str, file: str, where: str, pose: np.ndarray) -> list[Fault]:
    """Check that a pose is a rotation and a shift."""
    turn = np.asarray(pose)[:3, :3]
    off = max(np.abs(turn @ turn.T - np.eye(3)).max(), abs(np.linalg.det(turn) - 1.0))
    straight = np.array_equal(np.asarray(pose)[3], [0, 0, 0, 1])
    if off < 1e-9 and straight:
        return []
    return [Fault(check, file, where, "a rigid pose", f"one that is off by {off:.2g}")]


def object_faults(scene: Scene, objects: ObjectsFile, file: str) -> list[Fault]:
    """Compare ``objects.json`` with the description and the meshes."""
    expected, found = [item.id for item in scene.objects], [record.id for record in objects.objects]
    if expected != found:
        return unlike("objects", file, "ids", str(expected), str(found))
    faults: list[Fault] = []
    for item, record in zip(scene.objects, objects.objects, strict=True):
        where = f"object {item.id}"
        faults += unlike("objects", file, f"{where} name", item.name, record.name)
        faults += unlike("objects", file, f"{where} category", item.category, record.category)
        faults += unlike("objects", file, f"{where} world_T_object", item.world_T_object, record.world_T_object, EXACT)
        faults += rigid_faults("objects", file, f"{where} world_T_object", record.world_T_object)
        faults += unlike("objects", file, f"{where} size", _extent(item), record.size, ON_SURFACE)
        faults += _surface_points(item, record, file)
        faults += symmetry_faults(item, record, file)
        faults += _contents(scene, item, record, file)
    return faults


def media_faults(scene: Scene, objects: ObjectsFile, file: str) -> list[Fault]:
    """Compare media with the description's, and their constants with the ranges of real ones."""
    faults: list[Fault] = []
    media = [
        (f"object {record.id} material", record.material.medium)
        for record in objects.objects
        if isinstance(record.material, GlassMaterial)
    ]
    media += [(f"object {record.id} liquid", record.liquid.medium) for record in objects.objects if record.liquid]
    media += [
        (f"materials {number}", material.medium)
        for number, material in enumerate(objects.materials)
        if isinstance(material, MediumRecord)
    ]
    known = [_text(medium) for body in scene.vessels for part in body.interfaces for medium in (part.front, part.back)]
    for where, medium in media:
        if _text(medium) not in known and medium.name != "air":
            faults.append(Fault("media", file, where, "a medium of the scene's description", medium.name))
        faults += _constants(medium, where, file)
    return faults


def _constants(medium: Medium, where: str, file: str) -> list[Fault]:
    faults: list[Fault] = []
    for name, (low, high) in RANGES.items():
        value = getattr(medium, name)
        if value is not None and not low <= value <= high:
            faults.append(Fault("media", file, f"{where} {name}", f"{low:g} to {high:g}", f"{value:g}"))
    if min(medium.sigma_a) < 0.0:
        faults.append(Fault("media", file, f"{where} sigma_a", "none below 0", str(medium.sigma_a)))
    return faults


def _surface_points(item: SceneObject, record: ObjectRecord, file: str) -> list[Fault]:
    """Check that keypoints are on the surface, and that lines of liquids and mouths are on the vessel."""
    where = f"object {item.id}"
    solid = triangles_of_meshes(meshes_of(item))
    faults = _distances(solid, np.array(record.keypoints).reshape(-1, 3), f"{where} keypoints", file)
    for name in ("fill_lines", "openings"):
        for number, line in enumerate(getattr(record, name)):
            faults += _distances(solid, np.array(line), f"{where} {name} {number}", file)
    if isinstance(item, Prop):
        return faults
    expected = len({part.part for part in item.interfaces} & {"liquid_surface"})
    return faults + unlike("objects", file, f"{where} fill_lines", expected, min(len(record.fill_lines), 1))


def _distances(solid: np.ndarray, points: np.ndarray, where: str, file: str) -> list[Fault]:
    if not len(points):
        return []
    within = CHORD * diagonal(solid) if "openings" in where else ON_SURFACE
    worst = worst_distance(solid, points, within)
    if worst <= within:
        return []
    return [Fault("objects", file, where, "points on the surface", f"one {1e3 * worst:.3f} mm off")]


def _contents(scene: Scene, item: SceneObject, record: ObjectRecord, file: str) -> list[Fault]:
    """Compare liquid and volumes with the description and with the volumes of the meshes."""
    where = f"object {item.id}"
    if isinstance(item, Prop):
        return unlike("objects", file, f"{where} liquid", None, record.liquid and record.liquid.medium.name)
    liquid = None if item.liquid is None else item.liquid.model_dump_json()
    faults = unlike("objects", file, f"{where} liquid", liquid, record.liquid and record.liquid.model_dump_json())
    if record.volumes is None:
        return faults  # as in data sets of earlier versions
    glass = _volume(solid_meshes(item))
    faults += _near(glass, record.volumes.glass, VOLUME, f"{where} volumes.glass", file)
    if item.liquid is None:
        return faults + unlike("objects", file, f"{where} volumes.liquid", 0.0, record.volumes.liquid)
    # The surfaces of a liquid turn their backs to it, or their fronts, and together they close its body.
    media = [one.medium for one in item.liquids]
    body = _volume([part.mesh for part in item.interfaces if part.back in media])
    body -= _volume([part.mesh for part in item.interfaces if part.front in media])
    body -= _volume([mesh for mesh, front in standing_in(scene, item) if front in media])
    stated = sum(one.volume for one in item.liquids)
    faults += _near(stated, record.volumes.liquid, EXACT, f"{where} volumes.liquid", file)
    faults += _near(body, record.volumes.liquid, FACETS, f"{where} volumes.liquid", file)
    brimful = item.liquid.volume / item.liquid.fill
    return faults + _near(brimful, record.volumes.brimful or 0.0, FACETS, f"{where} volumes.brimful", file)


def _near(expected: float, found: float, relative: float, where: str, file: str) -> list[Fault]:
    close = abs(found - expected) <= relative * abs(expected)
    return [] if close else [Fault("objects", file, where, f"{expected:.6g} m^3", f"{found:.6g} m^3")]


def _volume(meshes: list[Mesh]) -> float:
    """Return the signed volume below faces [m^3]: of prisms from each face down to z = 0, which closed surfaces sum."""
    total = 0.0
    for mesh in meshes:
        a, b, c = np.moveaxis(mesh.vertices.astype(np.float64)[mesh.faces], 1, 0)
        area = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
        total += float((area * (a + b + c)[:, 2] / 3.0).sum())
    return total


def _extent(item: SceneObject) -> np.ndarray:
    """Return the extent of an object's solid: of a vessel that of its glass, above which ice may float."""
    return np.ptp(np.concatenate([mesh.vertices for mesh in solid_meshes(item)]).astype(np.float64), axis=0)


def _text(medium: Medium) -> str:
    return medium.model_dump_json()
