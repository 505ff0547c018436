"""Whether a scene can exist: what a picture of it would otherwise show as nonsense is refused by name."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from ...core.errors import InputError
from ...core.mesh import Mesh, joined
from ..description.scene import Interface, Prop, Scene, Vessel, glass_solid, liquid_solid
from ..optics.medium import Medium
from ..placement.overlap import ALLOWANCE, Solid, overlap
from .validate_fields import check_fields

#: Largest relative difference between a liquid's volume and that of its body: facets of the coarsest meshes cut off
#: most of that, and the default ones a twentieth of a percent.
VOLUME_TOLERANCE = 0.01


def check_scene(scene: Scene) -> None:
    """Refuse a scene that cannot exist.

    Descriptions are checked field by field when they are read; this looks at what the fields say together, and again
    at the media, since a changed copy of a description is not validated.

    Parameters
    ----------
    scene : Scene
        From `draw_scene`, from a file, or made by hand.

    Raises
    ------
    InputError
        Naming the object: fields that contradict each other (`consistency.check_fields`), a refractive index below 1,
        a negative absorption, glass or a liquid whose surface is not closed or is turned inside out, a liquid above
        the rim or of another volume, an object in the table, two objects in each other.
    """
    check_fields(scene)
    for vessel in scene.vessels:
        _check_media(vessel)
        _check_solids(vessel)
        _check_liquid(vessel)
    solids = {item.name: _solid(item) for item in scene.objects}
    for name, solid in solids.items():
        lowest = float(solid.points[:, 2].min())
        if lowest < -ALLOWANCE:
            raise InputError(name, "an object above the table's top (z = 0)", f"{-1e3 * lowest:.1f} mm below it")
    for (name, solid), (other, another) in combinations(solids.items(), 2):
        if overlap(solid, another):
            raise InputError(name, f"a place of its own (up to {1e3 * ALLOWANCE:g} mm)", f"that it overlaps {other}")


def _check_media(vessel: Vessel) -> None:
    for where, medium in _media(vessel):
        if not 1.0 <= medium.eta < np.inf:
            raise InputError(f"{where}, medium {medium.name}", "a refractive index of at least 1", medium.eta)
        for value in medium.sigma_a:
            if not 0.0 <= value < np.inf:
                raise InputError(f"{where}, medium {medium.name}", "an absorption of at least 0 per metre", value)
    for interface in vessel.interfaces:
        if interface.front == interface.back:
            where = f"{vessel.name}, {interface.part}"
            raise InputError(where, "two media, one on each side", f"{interface.front.name} on both")


def _media(vessel: Vessel) -> Iterator[tuple[str, Medium]]:
    yield f"{vessel.name}, glass", vessel.glass
    if vessel.liquid is not None:
        yield f"{vessel.name}, liquid", vessel.liquid.medium
    for interface in vessel.interfaces:
        yield f"{vessel.name}, {interface.part}, front", interface.front
        yield f"{vessel.name}, {interface.part}, back", interface.back


def _check_solids(vessel: Vessel) -> None:
    parts = [interface.part for interface in vessel.interfaces]
    expected = ["outside"] if vessel.liquid is None else ["liquid_surface", "outside", "wet_wall"]
    if sorted(parts) != expected:
        raise InputError(vessel.name, f"the interfaces {', '.join(expected)}", ", ".join(parts) or "none")
    _check_closed(f"{vessel.name}, glass", glass_solid(vessel))
    if vessel.liquid is not None:
        _check_closed(f"{vessel.name}, liquid", liquid_solid(vessel))


def _check_closed(where: str, mesh: Mesh) -> None:
    """Refuse a mesh with an edge that is not run through once in each direction, or with its inside out."""
    # As bytes: rows of plain memory sort much faster than rows of numbers. Adding 0 makes -0 the same as 0.
    _, index = np.unique(np.ascontiguousarray(mesh.vertices + np.float32(0.0)).view("V12").ravel(), return_inverse=True)
    faces = index.reshape(-1)[mesh.faces].astype(np.int64)
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    count = int(index.max()) + 1
    there, back = np.sort(start * count + end), np.sort(end * count + start)
    if (there[1:] == there[:-1]).any() or not np.array_equal(there, back):
        open_edges = len(np.setxor1d(there, back, assume_unique=False))
        raise InputError(where, "a closed surface, each edge between two triangles", f"{open_edges} loose edges")
    volume = _volume(mesh)
    if volume <= 0.0:
        raise InputError(where, "normals that point out of the body", f"a volume of {volume:.3e} m^3")


def _volume(mesh: Mesh) -> float:
    """Return the volume of a closed mesh [m^3]: the sum of its triangles' tetrahedra with the origin."""
    corners = mesh.vertices.astype(np.float64)[mesh.faces]
    return float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))) / 6.0


def _check_liquid(vessel: Vessel) -> None:
    if vessel.liquid is None:
        return
    rim = vessel.inner[-1][1]
    surface = next(interface for interface in vessel.interfaces if interface.part == "liquid_surface")
    highest = max(vessel.liquid.contact, vessel.liquid.level, float(surface.mesh.bounds[1, 2]))
    if highest > rim:
        raise InputError(f"{vessel.name}, liquid", f"a surface below the rim at {rim:.4f} m", f"{highest:.4f} m")
    stated, body = vessel.liquid.volume, _volume(liquid_solid(vessel))
    if not abs(stated - body) <= VOLUME_TOLERANCE * body:
        raise InputError(f"{vessel.name}, liquid, volume", f"that of its body, {body:.4g} m^3", f"{stated:.4g} m^3")


def _solid(item: Vessel | Prop) -> Solid:
    """Return the body as others meet it: a vessel with its liquid, or a prop."""
    if isinstance(item, Prop):
        mesh = item.mesh
    else:
        mesh = joined([part.mesh for part in item.interfaces if _is_outer(part)], f"{item.name}-body")
    rotation, origin = item.world_T_object[:3, :3], item.world_T_object[:3, 3]
    return Solid(mesh.vertices.astype(np.float64) @ rotation.T + origin, mesh.faces)


def _is_outer(interface: Interface) -> bool:
    return interface.part != "wet_wall"
