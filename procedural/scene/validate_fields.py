"""Whether the fields of a scene say the same thing: names, poses, sizes, profiles and cameras."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

import numpy as np

from ...core.errors import InputError
from ...core.mesh import Mesh
from ..description.scene import FIRST_OBJECT_ID, Prop, Scene, Vessel, glass_solid
from ..description.surroundings import Camera

#: Largest instance id: `instances.png` holds 16 bits a pixel.
LARGEST_ID = (1 << 16) - 1
#: Largest error of a rotation's entries, and of its rows' products [1]. Poses typed with seven digits pass; the error
#: moves a point one metre away by a micrometre.
RIGID_TOLERANCE = 1e-6
#: Largest distance between a mesh's bounds and the box that `size` says [m]: below what a depth picture can show.
SIZE_TOLERANCE = 1e-4
#: Longest side of a picture [px], as `CameraSettings` allows it; the product of two is 2^28 pixels.
LONGEST_SIDE = 16384
#: Smallest and largest exposure. A map of halves holds radiances from 6e-8 to 65504, which meter as 2e7 and 2e-5; the
#: rest is room for maps of floats in other units.
EXPOSURES = (1e-12, 1e12)


def check_fields(scene: Scene) -> None:
    """Refuse a scene whose fields contradict each other or cannot be stored.

    Raises
    ------
    InputError
        Naming the object or camera, and the field.
    """
    _check_identities(scene)
    for where, matrix in _poses(scene):
        check_rigid(where, matrix)
    _check_size("table, size", scene.table.mesh, np.array([*scene.table.size]), top=True)
    for item in scene.objects:
        if isinstance(item, Vessel):
            _check_profiles(item)
        mesh = item.mesh if isinstance(item, Prop) else glass_solid(item)
        _check_size(f"{item.name}, size", mesh, np.array(item.size))
    for number, camera in enumerate(scene.cameras):
        _check_camera(f"camera {number}", camera)


def check_rigid(where: str, matrix: np.ndarray) -> None:
    """Refuse a (4, 4) matrix that is not a rotation and a shift; InputError says how it fails."""
    expected = "a rigid pose"
    if np.abs(matrix[3] - [0.0, 0.0, 0.0, 1.0]).max() > 0.0:
        raise InputError(where, f"{expected}, last row 0 0 0 1", matrix[3].tolist())
    rotation = matrix[:3, :3]
    error = float(np.abs(rotation.T @ rotation - np.eye(3)).max())
    # Written so that NaN is refused as well.
    if not error <= RIGID_TOLERANCE:
        raise InputError(where, f"{expected}, axes at right angles and of length 1", f"them off by {error:.3g}")
    if np.linalg.det(rotation) < 0.0:
        raise InputError(where, f"{expected}, right-handed", "a mirrored one")


def _check_identities(scene: Scene) -> None:
    ids: dict[int, str] = {}
    names: set[str] = set()
    for item in chain(scene.vessels, scene.props):
        if not FIRST_OBJECT_ID <= item.id <= LARGEST_ID:
            raise InputError(f"{item.name}, id", f"{FIRST_OBJECT_ID} to {LARGEST_ID}", item.id)
        if item.id in ids:
            raise InputError(f"{item.name}, id", "one of its own", f"{item.id}, which {ids[item.id]} has")
        if item.name in names:
            raise InputError(f"{item.name}, name", "one of its own", f"it twice (id {item.id} again)")
        ids[item.id] = item.name
        names.add(item.name)


def _poses(scene: Scene) -> Iterator[tuple[str, np.ndarray]]:
    for item in scene.objects:
        yield f"{item.name}, world_T_object", item.world_T_object
    for number, camera in enumerate(scene.cameras):
        yield f"camera {number}, world_T_camera", camera.world_T_camera
    for number, light in enumerate(scene.lights):
        yield f"light {number}, world_T_light", light.world_T_light


def _check_profiles(vessel: Vessel) -> None:
    for field in ("outer", "inner"):
        count = len(getattr(vessel, field))
        if count < 2:
            raise InputError(f"{vessel.name}, {field}", "a profile of at least 2 points", count)


def _check_size(where: str, mesh: Mesh, size: np.ndarray, top: bool = False) -> None:
    """Refuse a mesh that does not fill the box about the origin, or the one that hangs below it."""
    if len(mesh.faces) == 0:
        raise InputError(where, f"triangles in mesh {mesh.name}", "none")
    middle = np.array([0.0, 0.0, -0.5 * size[2] if top else 0.0])
    box = np.stack([middle - 0.5 * size, middle + 0.5 * size])
    if not np.abs(mesh.bounds - box).max() <= SIZE_TOLERANCE:
        place = "hung from the origin" if top else "about the origin"
        found = ", ".join(f"{low:.4g} to {high:.4g}" for low, high in mesh.bounds.T)
        expected = f"the extent of mesh {mesh.name}, {place} ({found} m)"
        raise InputError(where, expected, " x ".join(f"{side:.4g}" for side in size) + " m")


def _check_camera(where: str, camera: Camera) -> None:
    for field in ("width", "height"):
        side = getattr(camera, field)
        if not 1 <= side <= LONGEST_SIDE:
            raise InputError(f"{where}, {field}", f"1 to {LONGEST_SIDE} px", side)
    least, most = EXPOSURES
    if not least <= camera.exposure <= most:
        raise InputError(f"{where}, exposure", f"{least:g} to {most:g}", camera.exposure)
    for field in ("focal", "baseline"):
        value = getattr(camera, field)
        if not 0.0 < value < np.inf:
            raise InputError(f"{where}, {field}", "a finite number above 0", value)
    if not np.isfinite(camera.centre).all():
        raise InputError(f"{where}, centre", "finite numbers", camera.centre)
