"""Whether a scene can exist: what a picture of it would otherwise show as nonsense is refused by name."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain, combinations

import numpy as np

from ...core.arguments import check_type
from ...core.errors import InputError
from ...core.mesh import Mesh, check_closed, volume_of
from ...core.pose import check_rigid
from ..description.camera import LONGEST_SIDE, Camera
from ..description.edits import check_above_table, check_pair, in_world, solid_of
from ..description.scene import (
    FIRST_OBJECT_ID,
    GlassBody,
    Liquid,
    MeshVessel,
    Prop,
    Scene,
    Vessel,
    glass_solid,
    liquid_solid,
)
from ..description.surroundings import FIRST_ROOM_ID
from ..optics.medium import AIR
from ..placement.overlap import Solid, contains
from ..profiles.liquid import brimful_volume, level_of_volume
from .fields import check_fields
from .solids import body_mesh
from .validate_light import check_lamp, check_sun

#: Largest relative difference between a liquid's volume and that of its body: facets of the coarsest meshes cut off
#: most of that, and the default ones a twentieth of a percent.
VOLUME_TOLERANCE = 0.01
#: Largest relative difference between a solid's volume and that of its surfaces when these are cut: rounding of single
#: precision at the contact line.
SOLID_TOLERANCE = 1e-4
#: Largest instance id: `instances.png` holds 16 bits a pixel, and the last ones are those of a room's surfaces.
LARGEST_ID = FIRST_ROOM_ID - 1
#: Largest distance between a mesh's bounds and the box that `size` states [m]: below what a depth picture can show.
SIZE_TOLERANCE = 1e-4
#: Smallest and largest exposure. A map of halves holds radiances from 6e-8 to 65504, which meter as 2e7 and 2e-5; the
#: rest is room for maps of floats in other units.
EXPOSURES = (1e-12, 1e12)


def check_scene(scene: Scene) -> None:
    """Refuse a scene that cannot exist.

    Every field is checked again, since a changed copy is not validated (`fields.check_fields`). Then this looks at what
    the fields say together.

    Parameters
    ----------
    scene : Scene
        From `draw_scene`, from a file, or made by hand.

    Raises
    ------
    InputError
        Naming the object or camera: a field with an impossible value, an id or name that two objects have, a pose that
        is not rigid, a size that is not that of the mesh, interfaces whose media or roughness are not those of their
        body, glass or a liquid whose surface is not closed or is inside out, a liquid above the rim or of another
        volume, an object in the table, two objects that overlap, a camera that no file can hold, or that is inside an
        object, a sun smaller or brighter than the real one, a lamp brighter than its kind can be, outside its room, or
        in an object or an eye (`validate_light`).
    """
    check_type("scene", scene, Scene, "a Scene, from gw.draw or gw.load_scene")
    check_fields(scene)
    _check_identities(scene)
    for where, matrix in _poses(scene):
        check_rigid(where, matrix)
    _check_size("table, size", scene.table.mesh, np.array([*scene.table.size]), top=True)
    for item in scene.objects:
        if isinstance(item, GlassBody):
            _check_parts(item)
        if isinstance(item, Vessel):
            _check_profiles(item)
        if isinstance(item, MeshVessel):
            _check_solid(item)
        if isinstance(item, Prop):
            _check_pieces(item)
        _check_size(f"{item.name}, size", body_mesh(item), np.array(item.size))
    for number, camera in enumerate(scene.cameras):
        _check_camera(f"camera {number}", camera)
    for body in scene.vessels:
        _check_media(body)
        _check_interfaces(body)
        _check_liquid(body)
    check_sun(scene)
    _check_places(scene)


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


def _check_parts(body: GlassBody) -> None:
    parts = [interface.part for interface in body.interfaces]
    expected = ["outside"] if body.liquid is None else ["liquid_surface", "outside", "wet_wall"]
    if sorted(parts) != expected:
        raise InputError(body.name, f"the interfaces {', '.join(expected)}", ", ".join(parts) or "none")


def _check_pieces(prop: Prop) -> None:
    count = sum(piece.faces for piece in prop.pieces)
    if count != len(prop.mesh.faces):
        raise InputError(f"{prop.name}, parts", f"parts of {len(prop.mesh.faces)} faces together", count)
    for piece in prop.parts:
        if piece.faces == 0:
            raise InputError(f"{prop.name}, parts", "faces in each of several parts", f"none of {piece.material.name}")
    for piece in prop.pieces:
        if piece.material.base_colour.kind == "vertices" and prop.mesh.colours is None:
            where = f"{prop.name}, {piece.material.name}"
            raise InputError(where, f"a mesh with colours ({prop.mesh.name}), as its texture says", "one without")


def _check_profiles(vessel: Vessel) -> None:
    for field in ("outer", "inner"):
        count = len(getattr(vessel, field))
        if count < 2:
            raise InputError(f"{vessel.name}, {field}", "a profile of at least 2 points", count)


def _check_solid(vessel: MeshVessel) -> None:
    """Refuse a solid that is not the glass between the interfaces: its cavities would be those of another one."""
    where = f"{vessel.name}, solid"
    check_closed(where, vessel.solid)
    _check_size(where, vessel.solid, np.array(vessel.size))
    stated, found = volume_of(vessel.solid), volume_of(glass_solid(vessel))
    if not abs(stated - found) <= SOLID_TOLERANCE * found:
        raise InputError(where, f"the glass between its interfaces, {found:.4g} m^3", f"{stated:.4g} m^3")
    if vessel.liquid is not None and not vessel.cavities:
        raise InputError(f"{vessel.name}, cavities", "one that holds its liquid", "none")


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


def _check_media(body: GlassBody) -> None:
    """Refuse interfaces between equal media."""
    for interface in body.interfaces:
        if interface.front == interface.back:
            where = f"{body.name}, {interface.part}"
            raise InputError(where, "two media, one on each side", f"{interface.front.name} on both")


def _check_interfaces(body: GlassBody) -> None:
    """Refuse interfaces that differ from the fields of their body, or do not close it."""
    glass, air = ("the body's glass", body.glass), ("air", AIR)
    liquid = ("its liquid", AIR if body.liquid is None else body.liquid.medium)
    sides = {"outside": (air, glass), "wet_wall": (liquid, glass), "liquid_surface": (air, liquid)}
    for interface in body.interfaces:
        where = f"{body.name}, {interface.part}"
        for side, (what, medium) in zip(("front", "back"), sides[interface.part], strict=True):
            found = getattr(interface, side)
            if found != medium:
                same_name = f"{found.name} with other constants" if found.name == medium.name else found.name
                raise InputError(f"{where}, {side}", f"{what} ({medium.name})", same_name)
        roughness = 0.0 if interface.part == "liquid_surface" else body.roughness
        if interface.roughness != roughness:
            raise InputError(f"{where}, roughness", f"{roughness:g}, as its body says", f"{interface.roughness:g}")
    check_closed(f"{body.name}, glass", glass_solid(body))
    if body.liquid is not None:
        check_closed(f"{body.name}, liquid", liquid_solid(body))


def _check_liquid(body: GlassBody) -> None:
    if body.liquid is None:
        return
    rim = body.inner[-1][1] if isinstance(body, Vessel) else 0.5 * body.size[2]
    surface = next(interface for interface in body.interfaces if interface.part == "liquid_surface")
    highest = max(body.liquid.contact, body.liquid.level, float(surface.mesh.bounds[1, 2]))
    if highest > rim:
        raise InputError(f"{body.name}, liquid", f"a surface below the rim at {rim:.4f} m", f"{highest:.4f} m")
    stated, volume = body.liquid.volume, volume_of(liquid_solid(body))
    if not abs(stated - volume) <= VOLUME_TOLERANCE * volume:
        raise InputError(f"{body.name}, liquid, volume", f"that of its body, {volume:.4g} m^3", f"{stated:.4g} m^3")
    _check_heights(body, body.liquid, surface.mesh)


def _check_heights(body: GlassBody, liquid: Liquid, surface: Mesh) -> None:
    """Refuse a record of a liquid that differs from its surface, or from what the vessel's profile holds."""
    if isinstance(body, MeshVessel):
        _check_mesh_heights(body.name, liquid, surface)
        return
    radii = np.hypot(*surface.vertices[:, :2].T)
    stated = {"contact": liquid.contact, "centre": liquid.centre}
    found = {"contact": _rim_height(surface), "centre": surface.vertices[radii.argmin(), 2]}
    if isinstance(body, Vessel):
        inner = np.array(body.inner)
        stated |= {"level": liquid.level}
        found |= {"level": level_of_volume(inner, liquid.volume)}
        fill = liquid.volume / brimful_volume(inner)
        if not abs(liquid.fill - fill) <= VOLUME_TOLERANCE:
            raise InputError(f"{body.name}, liquid, fill", f"that of its volume, {fill:.3f}", f"{liquid.fill:.3f}")
    elif not body.symmetric:
        return
    for field, height in found.items():
        if not abs(stated[field] - height) <= SIZE_TOLERANCE:
            expected = f"that of its surface, {height:.4f} m"
            raise InputError(f"{body.name}, liquid, {field}", expected, f"{stated[field]:.4f} m")


def _check_mesh_heights(name: str, liquid: Liquid, surface: Mesh) -> None:
    """Refuse a record that differs from the liquid's surface, which has a piece in each cavity."""
    for field, heights in (("contact", _border_heights(surface)), ("centre", surface.vertices[:, 2])):
        stated = getattr(liquid, field)
        nearest = float(heights[np.abs(heights - stated).argmin()])
        if not abs(nearest - stated) <= SIZE_TOLERANCE:
            raise InputError(f"{name}, liquid, {field}", f"that of its surface, {nearest:.4f} m", f"{stated:.4f} m")
    low, high = sorted((liquid.centre, liquid.contact))
    if not low - SIZE_TOLERANCE <= liquid.level <= high + SIZE_TOLERANCE:
        expected = f"that of its surface, {low:.4f} to {high:.4f} m"
        raise InputError(f"{name}, liquid, level", expected, f"{liquid.level:.4f} m")


def _rim_height(surface: Mesh) -> float:
    """Return the mean height of a surface's border, where it meets the wall; under a neck it is not the widest ring."""
    return float(_border_heights(surface).mean())


def _border_heights(surface: Mesh) -> np.ndarray:
    """Return the heights of the points on a surface's border [m]."""
    positions, index = np.unique(surface.vertices, axis=0, return_inverse=True)
    corners = index.reshape(-1)[surface.faces]
    edges = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    border, count = np.unique(edges, axis=0, return_counts=True)
    return positions[np.unique(border[count == 1]), 2]


def _check_places(scene: Scene) -> None:
    solids = {item.name: solid_of(item) for item in scene.objects}
    for name, solid in solids.items():
        check_above_table(name, solid)
    for (item, solid), (other, another) in combinations(zip(scene.objects, solids.values(), strict=True), 2):
        check_pair(item, solid, other, another)
    solids |= {"the table": in_world(scene.table.mesh, np.eye(4))}
    _check_eyes(scene, solids)
    for number in range(len(scene.lights)):
        check_lamp(scene, number, solids)


def _check_eyes(scene: Scene, solids: dict[str, Solid]) -> None:
    """Refuse a camera of which an eye is inside an object: light paths begin in air."""
    poses = [pose for camera in scene.cameras for pose in (camera.world_T_camera, camera.world_T_right)]
    eyes = np.array([pose[:3, 3] for pose in poses])
    for name, body in solids.items():
        near = ((eyes >= body.points.min(0)) & (eyes <= body.points.max(0))).all(1).nonzero()[0]
        for index in near[contains(body, eyes[near])] if len(near) else near:
            view, eye = divmod(int(index), 2)
            where = f"camera {view}, {('left', 'right')[eye]} eye"
            raise InputError(where, "a place in the air", f"({', '.join(f'{x:.3f}' for x in eyes[index])}), in {name}")
