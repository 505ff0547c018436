"""What is wrong with the bodies of a drawn scene, by code that has no part in drawing them.

Surfaces that are not closed, walls that are thinner or thicker than their vessel says, volumes of liquids beside a
closed form or a Monte Carlo integral, and bodies that overlap.
"""

from __future__ import annotations

from hashlib import sha256
from itertools import combinations, pairwise
from typing import Any

import numpy as np
import trimesh
from scipy.spatial import cKDTree

from glassware.core.errors import InputError
from glassware.core.mesh import Mesh, as_trimesh, check_closed
from glassware.procedural.cavities.interior import interior_of, most_volume
from glassware.procedural.cavities.wall import spread, thicknesses
from glassware.procedural.description.edits import in_world, solid_of
from glassware.procedural.description.mesh_vessel import refilled_mesh
from glassware.procedural.description.scene import (
    GlassBody,
    MeshVessel,
    Prop,
    Scene,
    SceneObject,
    Vessel,
    content_solid,
    glass_solid,
    liquid_solid,
)
from glassware.procedural.description.standing import wetted_surfaces
from glassware.procedural.optics.catalogue import water
from glassware.procedural.placement.overlap import Solid, overlap

#: Largest deviation of the thinnest wall from what the vessel says, and of volumes [1].
WALL, VOLUME = 0.05, 0.01
#: Lines of the Monte Carlo integral of a volume along each side of its box, and of a second one where the first is off
#: by more than a fraction of the bound [1].
LINES, MORE_LINES, UNSURE = 48, 192, 0.7
#: Rays into the glass of a wall that seems too thick or too thin, and quantile of their lengths that is its thickness.
RAYS, _SHORTEST = 2500, 0.002
#: Distance of the points on profiles between which walls are measured [m].
_SPACING = 5e-5
#: How full a vessel without a profile is made, of what it holds, so that its inside is known [1], and quantile of the
#: distances between inside and outside that is its thinnest wall: chords of the mesh are nearer in single places [1].
_NEARLY_FULL, _THINNEST = 0.999, 0.01


def checked(scene: Scene) -> dict[str, Any]:
    """Return what a scene's bodies are found to be, as plain data.

    ``faults`` are lines about what is wrong. ``walls`` are the measured walls over those asked for, ``volumes`` the
    stated volumes over those found by closed form and by Monte Carlo, ``overlaps`` the pairs of names that overlap,
    of ``pairs``; ``shapes`` has for each vessel its family, a digest of its glass and its extent [mm].
    """
    found: dict[str, Any] = {"faults": [], "walls": {}, "closed_forms": {}, "volumes": {}, "shapes": []}
    for vessel in scene.vessels:
        for name, mesh in _surfaces(vessel, scene):
            try:
                check_closed(name, mesh)
            except InputError as error:
                found["faults"].append(str(error))
        if isinstance(vessel, Vessel | MeshVessel) and vessel.part_of is None:
            _measure(vessel, scene, found)
    solids = {item.name: solid_of(item) for item in scene.objects}
    pairs = list(combinations(scene.objects, 2))
    found["pairs"] = len(pairs)
    found["overlaps"] = [[a.name, b.name] for a, b in pairs if _overlap(a, b, solids)]
    return found


def _overlap(one: SceneObject, other: SceneObject, solids: dict[str, Solid]) -> bool:
    """Return whether two objects overlap; what stands in a vessel may be in its liquid, but not in its glass."""
    shapes = [
        in_world(glass_solid(item), item.world_T_object)
        if isinstance(item, GlassBody) and item.name == another.within
        else solids[item.name]
        for item, another in ((one, other), (other, one))
    ]
    return overlap(*shapes)


def _surfaces(vessel: GlassBody, scene: Scene) -> list[tuple[str, Mesh]]:
    """Return the surfaces of a vessel that have to be closed: of its glass, its liquids and what is in them."""
    pieces = wetted_surfaces(scene.objects, vessel)
    liquids = [liquid_solid(vessel, number, pieces) for number in range(len(vessel.liquids))]
    contents = [content_solid(vessel, number) for number in range(len(vessel.contents))]
    return [(f"{vessel.name} ({vessel.category})", mesh) for mesh in (glass_solid(vessel), *liquids, *contents)]


def _measure(vessel: Vessel | MeshVessel, scene: Scene, found: dict[str, Any]) -> None:
    glass = glass_solid(vessel)
    digest = sha256(glass.vertices.tobytes() + glass.faces.tobytes()).hexdigest()[:16]
    found["shapes"].append([vessel.category, digest, [1e3 * side for side in vessel.size]])
    if isinstance(vessel, Vessel):
        found["walls"][vessel.name] = [vessel.category, _wall_of_profile(vessel) / vessel.wall]
        for number in range(0 if vessel.contents else len(vessel.liquids)):
            if not any(item.within == vessel.name for item in scene.objects):
                held = sum(liquid.volume for liquid in vessel.liquids[: number + 1])
                form = below(np.array(vessel.inner), vessel.liquids[number].level)
                found["closed_forms"][f"{vessel.name}/{number}"] = [vessel.category, held / form]
    elif vessel.wall is not None and vessel.cavities:
        ratio = _wall_of_mesh(vessel) / vessel.wall
        # Below the level alone, and so without what is thinnest near the rim.
        found["walls"][vessel.name] = [vessel.category, ratio if abs(ratio - 1.0) < WALL else _wall_by_rays(vessel)]
    pieces = wetted_surfaces(scene.objects, vessel)
    for number, liquid in enumerate(vessel.liquids):
        solid = liquid_solid(vessel, number, pieces)
        ratio = liquid.volume / monte_carlo(solid, scene.scene_id)
        if abs(ratio - 1.0) > UNSURE * VOLUME:
            ratio = liquid.volume / monte_carlo(solid, scene.scene_id, MORE_LINES)
        found["volumes"][f"{vessel.name}/{number}"] = [vessel.category, ratio]


def below(profile: np.ndarray, level: float) -> float:
    """Return the volume of a solid of revolution below a level, from its profile (n, 2) upwards [m^3].

    Each pair of points gives a truncated cone, of pi / 3 h (a^2 + a b + b^2).
    """
    total = 0.0
    for (a, low), (b, high) in pairwise(profile):
        if low >= level:
            break
        end = min(high, level)
        b = a + (b - a) * ((end - low) / (high - low) if high > low else 1.0)
        total += np.pi / 3.0 * (end - low) * (a * a + a * b + b * b)
    return float(total)


def monte_carlo(mesh: Mesh, seed: int, lines: int = LINES) -> float:
    """Return the volume of a closed body by the length in it of vertical lines, one at random in each cell [m^3]."""
    corners = mesh.vertices[mesh.faces].astype(np.float64)
    low, high = mesh.bounds
    cell = (high - low)[:2] / lines
    rng = np.random.default_rng(seed)
    total = 0.0
    starts, ends = corners[..., 0].min(1), corners[..., 0].max(1)
    for column in range(lines):
        left = low[0] + column * cell[0]
        near = corners[(starts <= left + cell[0]) & (ends >= left)]
        lowest, highest = near[..., 1].min(1), near[..., 1].max(1)
        for row in range(lines):
            place = np.array([left, low[1] + row * cell[1]]) + cell * rng.random(2)
            total += _length(near[(lowest <= place[1]) & (highest >= place[1])], place)
    return total * float(cell.prod())


def _length(corners: np.ndarray, place: np.ndarray) -> float:
    """Return the length of a vertical line in a body: heights where it leaves it, less those where it enters."""
    p, q, r = (corners[:, k, :2] - place for k in range(3))
    areas = np.stack([_cross(q, r), _cross(r, p), _cross(p, q)], axis=1)
    total = areas.sum(1)
    hit = (total != 0.0) & ((areas * np.sign(total)[:, None]) >= 0.0).all(1)
    heights = (areas[hit] * corners[hit, :, 2]).sum(1) / total[hit]
    return float((np.sign(total[hit]) * heights).sum())


def _cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]


def _wall_of_profile(vessel: Vessel) -> float:
    """Return the least distance between inside and outside of a profile, without its rounded rim [m]."""
    outer, inner = np.array(vessel.outer), np.array(vessel.inner)
    # The rim is round: its half circle ends a wall's thickness from its crown.
    curves = [_fine(curve) for curve in (outer, inner)]
    outside, inside = (curve[np.hypot(*(curve - outer[-1]).T) > 1.1 * vessel.wall + 5e-5] for curve in curves)
    return float(cKDTree(outside).query(inside)[0].min())


def _fine(points: np.ndarray) -> np.ndarray:
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    at = np.linspace(0.0, lengths[-1], int(lengths[-1] / _SPACING) + 2)
    return np.stack([np.interp(at, lengths, column) for column in points.T], axis=-1)


def _wall_of_mesh(vessel: MeshVessel) -> float:
    """Return the thickness of the wall below the surface of a liquid that nearly fills the vessel [m]."""
    assert vessel.wall is not None
    bare = refilled_mesh(vessel.model_copy(update={"layers": (), "contents": ()}), None)
    inside = interior_of(vessel.solid)
    full = refilled_mesh(bare, water(), _NEARLY_FULL * most_volume(inside) / inside.volume, inside)
    assert full.liquid is not None
    meshes = {part.part: part.mesh for part in full.interfaces}
    wet, dry = (meshes[part].vertices[meshes[part].faces].astype(np.float64) for part in ("wet_wall", "outside"))
    # The dry inside above the level is part of the outside; it is farther than the wall from what is well below.
    wet = wet[wet[..., 2].max(1) < full.liquid.level - 2.0 * vessel.wall - 1e-3]
    space = _sealed(meshes["outside"], vessel) if vessel.category == "double-walled glass" else np.zeros(len(dry), bool)
    corners, inside_faces = np.concatenate([wet, dry]), np.arange(len(wet) + len(dry)) < len(wet)
    if space.any():  # each of the two walls is between the space and something else
        sealed = np.concatenate([np.zeros(len(wet), bool), space])
        return float(np.quantile(thicknesses(corners, sealed, ~sealed), _THINNEST))
    return float(np.quantile(thicknesses(corners, inside_faces, ~inside_faces), _THINNEST))


def _wall_by_rays(vessel: MeshVessel) -> float:
    """Return the thickness of the thinnest wall over that asked for, by rays from all of the surface into the glass.

    (Moeller and Trumbore 1997, "Fast, minimum storage ray-triangle intersection".)
    """
    assert vessel.wall is not None
    corners = vessel.solid.vertices[vessel.solid.faces].astype(np.float64)
    points, face = spread(corners, RAYS)
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    inwards = -np.cross(one, other)[face]
    inwards /= np.linalg.norm(inwards, axis=1, keepdims=True)
    lengths = [
        _to_surface(point, along, corners[:, 0], one, other) for point, along in zip(points, inwards, strict=True)
    ]
    return float(np.quantile(lengths, _SHORTEST) / vessel.wall)


def _to_surface(point: np.ndarray, along: np.ndarray, corner: np.ndarray, one: np.ndarray, other: np.ndarray) -> float:
    """Return how far a ray from a point of a surface goes to the surface again [m]; infinite where it does not."""
    across = np.cross(along, other)
    determinant = (one * across).sum(1)
    inverse = np.divide(1.0, determinant, out=np.zeros_like(determinant), where=np.abs(determinant) > 1e-18)
    offset = point - corner
    turned = np.cross(offset, one)
    u, v, distance = (offset * across).sum(1) * inverse, turned @ along * inverse, (other * turned).sum(1) * inverse
    met = (inverse != 0.0) & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (distance > 2e-5)
    return float(distance[met].min(initial=np.inf))


def _sealed(outside: Mesh, vessel: MeshVessel) -> np.ndarray:
    """Return which faces of a double-walled glass's surface are those of its sealed space: a surface of its own."""
    mesh = as_trimesh(vessel.solid)
    labels = trimesh.graph.connected_component_labels(mesh.face_adjacency, node_count=len(mesh.faces))
    inside = {row.tobytes() for row in vessel.solid.vertices[vessel.solid.faces[labels != labels[0]].ravel()]}
    points = outside.vertices[outside.faces]
    return np.array([all(row.tobytes() in inside for row in face) for face in points])


def kinds_in(scene: Scene) -> dict[str, list[str]]:
    """Return the names of what is in a scene, by what they name; a name as often as it is there."""
    hosts = [item for item in scene.vessels if item.part_of is None and item.within is None]
    liquids = [liquid for vessel in scene.vessels for liquid in vessel.liquids]
    layered = ["layers" for vessel in scene.vessels if vessel.layers]
    standing = [item.category for item in scene.objects if item.within is not None]
    contents = [content.kind for vessel in scene.vessels for content in vessel.contents]
    return {
        "families": [item.category for item in hosts],
        "parts": [item.category for item in scene.objects if item.part_of is not None],
        "contents": [*contents, *layered, *standing, *["turbid" for liquid in liquids if liquid.turbid]],
        "glasses": [item.glass.name for item in hosts],
        "liquids": [liquid.medium.name for liquid in liquids],
        "props": [item.category for item in scene.props if item.part_of is None and item.within is None],
        "tables": [str(scene.table.kind)],
        "materials": sorted({part.material.name for item in scene.props for part in item.pieces}),
        "surroundings": [str(scene.environment.kind)],
    }


def leaning(item: GlassBody | Prop) -> float:
    """Return the angle between an object's axis and the vertical [rad]."""
    return float(np.arccos(np.clip(item.world_T_object[2, 2], -1.0, 1.0)))
