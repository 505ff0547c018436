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
from ..description.edits import check_above_table, check_level, check_pair, in_world, solid_of
from ..description.scene import (
    FIRST_OBJECT_ID,
    GlassBody,
    MeshVessel,
    Prop,
    Scene,
    Vessel,
    glass_solid,
)
from ..description.surroundings import FIRST_ROOM_ID, Table
from ..placement.overlap import Solid, contains
from ..surroundings.table import outline
from ..tables.prints import lies_on
from .fields import check_fields
from .solids import body_mesh
from .validate_contents import SIZE_TOLERANCE, check_contents, check_parts
from .validate_light import check_lamp, check_sun

#: Largest relative difference between a solid's volume and that of its surfaces when these are cut: rounding of single
#: precision at the contact line.
SOLID_TOLERANCE = 1e-4
#: Largest instance id: `instances.png` holds 16 bits a pixel, and the last ones are those of a room's surfaces.
LARGEST_ID = FIRST_ROOM_ID - 1
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
        volume, a print beside the table's top, an object in the table, two objects that overlap, a camera that no file
        can hold, or that is inside an object, a sun smaller or brighter than the real one, a lamp brighter
        than its kind can be, outside its room, or in an object or an eye (`validate_light`).
    """
    check_type("scene", scene, Scene, "a Scene, from gw.draw or gw.load_scene")
    check_fields(scene)
    _check_identities(scene)
    for where, matrix in _poses(scene):
        check_rigid(where, matrix)
    _check_size("table, size", scene.table.mesh, np.array([*scene.table.size]), top=True)
    if scene.table.prints:
        _check_prints(scene.table)
    for item in scene.objects:
        if isinstance(item, GlassBody):
            check_parts(item)
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
        check_level(body)
        _check_media(body)
        check_contents(scene, body)
    check_sun(scene)
    _check_places(scene)


def _check_prints(table: Table) -> None:
    top = outline(table)
    for number, item in enumerate(table.prints):
        if not lies_on(item, top, -SIZE_TOLERANCE):
            low, high = top.min(axis=0), top.max(axis=0)
            expected = f"a print on the flat top, x {low[0]:.3f} to {high[0]:.3f}, y {low[1]:.3f} to {high[1]:.3f} m"
            reach = [f"{end:.3f}" for end in (*item.corners.min(axis=0), *item.corners.max(axis=0))]
            found = f"x {reach[0]} to {reach[2]}, y {reach[1]} to {reach[3]} m"
            raise InputError(f"table, prints {number} ({item.kind})", expected, found)


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


def _check_places(scene: Scene) -> None:
    solids = {item.name: solid_of(item) for item in scene.objects}
    for name, solid in solids.items():
        check_above_table(name, solid)
    _check_standing(scene)
    for (item, solid), (other, another) in combinations(zip(scene.objects, solids.values(), strict=True), 2):
        check_pair(item, solid, other, another)
    solids |= {"the table": in_world(scene.table.mesh, np.eye(4))}
    _check_eyes(scene, solids)
    for number in range(len(scene.lights)):
        check_lamp(scene, number, solids)


def _check_standing(scene: Scene) -> None:
    """Refuse objects in vessels that are not there."""
    names = [vessel.name for vessel in scene.vessels if isinstance(vessel, Vessel | MeshVessel)]
    for item in scene.objects:
        if item.within is not None and item.within not in names:
            raise InputError(f"{item.name}, within", f"a vessel of the scene ({', '.join(names)})", item.within)


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
