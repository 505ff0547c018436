"""Draw what leans in a vessel: a straw, a spoon or a stirring rod."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...core.errors import InputError
from ...core.mesh import Mesh
from ...core.weighted import weights_of
from ..description.bodies import FIRST_OBJECT_ID, GlassBody, Interface, Prop, SceneObject
from ..description.material import OpaqueMaterial, UniformTexture
from ..materials.draw import METALS
from ..optics.catalogue import glass_named
from ..optics.medium import AIR
from .lean import MOST_BEYOND, leaning
from .room import Room
from .settings import STANDING, ContentsSettings
from .shapes import rod, spoon, tube

#: Lengths that are sold [m]: straws of 140 (cocktail) to 250 mm, tea and latte spoons of 120 to 220 mm, stirring rods
#: of 150 to 300 mm.
LENGTHS = {"straw": (0.14, 0.25), "spoon": (0.12, 0.22), "stirring rod": (0.15, 0.30)}
#: Diameters of straws and of rods, and thickness of a straw's wall [m].
_STRAW, _ROD, _STRAW_WALL = (0.005, 0.008), (0.005, 0.008), (0.0003, 0.0005)
#: How far they stand out beyond the rim at least [m]: less would not be reached by fingers.
_STANDS_OUT = 0.015
#: How much a body may be in the glass [m]: a tenth of the overlap that counts as touching.
_TOUCHES = 5e-5
#: Length with which the tilt is sought [m]: longer than any vessel is deep.
_PROBE = 0.36
#: Colours of straws, linear Rec.709: black, white and paper, and the primaries of party straws.
_STRAWS = (
    (0.03, 0.03, 0.03),
    (0.75, 0.75, 0.72),
    (0.60, 0.52, 0.40),
    (0.55, 0.04, 0.04),
    (0.05, 0.30, 0.08),
    (0.05, 0.12, 0.50),
    (0.70, 0.42, 0.03),
    (0.60, 0.10, 0.30),
)


#: From a length [m] to a body.
Shape = Callable[[float], Mesh]


def draw_standing(
    rng: np.random.Generator,
    settings: ContentsSettings,
    vessel: GlassBody,
    room: Room,
    takes: Callable[[SceneObject], bool] = lambda _: True,
) -> tuple[SceneObject | None, int]:
    """Draw an object that leans in a vessel, in the vessel's frame, and how often another kind had to be drawn.

    None where none is drawn, or none leans that the vessel `takes` beside its liquids.

    Raises
    ------
    InputError
        Where one is asked for and none of the kinds leans there.
    """
    wanted, weights = rng.random() < settings.standing, weights_of(settings.standing_kinds)
    kinds = rng.permutation(list(weights)).tolist()
    chosen = rng.choice(len(weights), p=np.array(list(weights.values())) / sum(weights.values()))
    place, azimuth, thick, thin, colour = rng.uniform(size=5).tolist()
    if not wanted:
        return None, 0
    direction, axis = room.azimuth(azimuth), room.axis
    if direction is not None:
        room = room.turned(direction)
    # The others in turn where the one that is drawn finds no rest.
    first = list(weights)[int(chosen)]
    for tries, kind in enumerate([first, *(other for other in kinds if other != first)]):
        found = None if direction is None else _leaning(kind, _shape(kind, thick, thin), room, place)
        if found is not None and direction is not None:
            mesh, pose = found
            item = _item(kind, mesh, _turned(pose, direction, axis), vessel.name, colour)
            if takes(item):
                return item, tries
    if settings.standing == 1.0:
        depth = room.brim - room.floor
        expected = f"something that leans in {vessel.name} (a {vessel.category}, {1e3 * depth:.0f}mm deep)"
        others = [kind for kind in STANDING if kind not in weights]
        shapes = {kind: _shape(kind, thick, thin) for kind in others if direction is not None}
        working = [kind for kind, shape in shapes.items() if _leaning(kind, shape, room, place)]
        if working:
            expected += f", such as {working[0]}"
        raise InputError("vessels.contents.standing_kinds", expected, ", ".join(weights))
    return None, len(weights)


def _leaning(kind: str, shape: Shape, room: Room, place: float) -> tuple[Mesh, np.ndarray] | None:
    """Return a body of a length that stays in the vessel, and its pose; None where there is none."""
    found = leaning(shape(_PROBE), room)
    if found is None:
        return None
    least, most = LENGTHS[kind]
    least, most = max(least, found.reach + _STANDS_OUT), min(most, 2.0 * MOST_BEYOND * found.reach)
    if least > most:
        return None
    mesh, pose = shape(least + place * (most - least)), found.vessel_T_body
    if _is_clear(mesh, pose, room):
        return mesh, pose
    # A spoon of this length is wider where it meets the rim, which counts in corners.
    again = leaning(mesh, room)
    return None if again is None or not _is_held(mesh, again.reach) else (mesh, again.vessel_T_body)


def _is_clear(mesh: Mesh, pose: np.ndarray, room: Room) -> bool:
    points = mesh.vertices.astype(np.float64)
    return float(room.clearance(points @ pose[:3, :3].T + pose[:3, 3]).min()) > -_TOUCHES


def _is_held(mesh: Mesh, reach: float) -> bool:
    """Return whether a body stands out beyond the rim, and its middle lies between its foot and the rim."""
    length = float(mesh.bounds[1, 2])
    return reach + _STANDS_OUT <= length <= 2.0 * MOST_BEYOND * reach


def _shape(kind: str, thick: float, thin: float) -> Shape:
    def between(limits: tuple[float, float], t: float) -> float:
        return limits[0] + t * (limits[1] - limits[0])

    if kind == "straw":
        return lambda length: tube(0.5 * between(_STRAW, thick), between(_STRAW_WALL, thin), length, "straw")
    if kind == "spoon":
        size = 0.75 + 0.3 * thick
        bowl = (0.045 * size, 0.031 * size, 0.007 * size)
        return lambda length: spoon(length, bowl, (0.0045, 0.009 + 0.004 * thin), "spoon")
    return lambda length: rod(0.5 * between(_ROD, thick), length, "stirring-rod")


def _turned(pose: np.ndarray, azimuth: float, axis: np.ndarray) -> np.ndarray:
    c, s = np.cos(azimuth), np.sin(azimuth)
    turn = np.eye(4)
    turn[:2, :2] = [[c, -s], [s, c]]
    turn[:2, 3] = axis
    return turn @ pose


def _item(kind: str, mesh: Mesh, pose: np.ndarray, vessel: str, colour: float) -> SceneObject:
    name = f"{kind.replace(' ', '-')}-{vessel.rpartition('-')[2]}"
    centre = mesh.bounds.mean(0)
    centred = replace(mesh, name=name, vertices=mesh.vertices.astype(np.float64) - centre)
    x, y, z = np.ptp(centred.bounds, axis=0).tolist()
    world_T_object = pose.copy()
    world_T_object[:3, 3] += pose[:3, :3] @ centre
    common = {"id": FIRST_OBJECT_ID, "name": name, "category": kind, "within": vessel, "size": (x, y, z)}
    common |= {"symmetric": kind != "spoon", "world_T_object": world_T_object}
    if kind == "stirring rod":
        glass = glass_named("borosilicate glass 3.3")
        outside = Interface(part="outside", mesh=replace(centred, name=f"{name}-outside"), front=AIR, back=glass)
        return GlassBody.model_validate(common | {"glass": glass, "roughness": 0.0, "interfaces": (outside,)})
    if kind == "spoon":
        texture = UniformTexture(colour=METALS["steel"])
        material = OpaqueMaterial(name="stainless steel", base_colour=texture, roughness=0.2, metallic=1.0)
    else:
        texture = UniformTexture(colour=_STRAWS[int(colour * len(_STRAWS))])
        material = OpaqueMaterial(name="straw", base_colour=texture, roughness=0.45)
    return Prop.model_validate(common | {"mesh": centred, "material": material})
