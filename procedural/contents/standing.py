"""Draw what leans in a vessel: a straw, a spoon or a stirring rod."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...core.errors import InputError
from ...core.mesh import Mesh
from ...core.weighted import weights_of
from ..description.bodies import GlassBody, Interface, Prop, SceneObject, Vessel
from ..description.material import OpaqueMaterial, UniformTexture
from ..materials.draw import METALS
from ..optics.catalogue import glass_named
from ..optics.medium import AIR
from .lean import MOST_BEYOND, leaning
from .room import Room
from .settings import ContentsSettings
from .shapes import rod, spoon, tube

#: Lengths that are sold [m]: straws of 140 (cocktail) to 250 mm, tea and latte spoons of 120 to 220 mm, stirring rods
#: of 150 to 300 mm.
LENGTHS = {"straw": (0.14, 0.25), "spoon": (0.12, 0.22), "stirring rod": (0.15, 0.30)}
#: Diameters of straws and of rods, and thickness of a straw's wall [m].
_STRAW, _ROD, _STRAW_WALL = (0.005, 0.008), (0.005, 0.008), (0.0003, 0.0005)
#: How far they stand out beyond the rim at least [m]: less would not be reached by fingers.
_STANDS_OUT = 0.015
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


def draw_standing(
    rng: np.random.Generator, settings: ContentsSettings, vessel: Vessel, room: Room, id: int
) -> SceneObject | None:
    """Draw an object that leans in a vessel, in the vessel's frame; None where none is drawn or leans.

    Raises
    ------
    InputError
        Where one is asked for and none of the lengths leans there.
    """
    wanted, names = rng.random() < settings.standing, weights_of(settings.standing_kinds)
    weight = np.array(list(names.values()))
    kind = list(names)[int(rng.choice(len(weight), p=weight / weight.sum()))]
    place, azimuth, thick, thin, colour = rng.uniform(size=5).tolist()
    if not wanted:
        return None
    shape = _shape(kind, thick, thin)
    found = leaning(shape(_PROBE), room)
    least, most = LENGTHS[kind]
    if found is not None:
        least, most = max(least, found.reach + _STANDS_OUT), min(most, 2.0 * MOST_BEYOND * found.reach)
    if found is None or least > most:
        if settings.standing == 1.0:
            where, limit = (
                "vessels.contents.standing_kinds",
                f"something that leans in {vessel.name} (a {vessel.category})",
            )
            raise InputError(where, limit, kind)
        return None
    mesh = shape(least + place * (most - least))
    pose = _turned(found.vessel_T_body, 2.0 * np.pi * azimuth)
    return _item(kind, mesh, pose, vessel.name, id, colour)


def _shape(kind: str, thick: float, thin: float):
    def between(limits: tuple[float, float], t: float) -> float:
        return limits[0] + t * (limits[1] - limits[0])

    if kind == "straw":
        return lambda length: tube(0.5 * between(_STRAW, thick), between(_STRAW_WALL, thin), length, "straw")
    if kind == "spoon":
        size = 0.75 + 0.3 * thick
        bowl = (0.045 * size, 0.031 * size, 0.007 * size)
        return lambda length: spoon(length, bowl, (0.0045, 0.009 + 0.004 * thin), "spoon")
    return lambda length: rod(0.5 * between(_ROD, thick), length, "stirring-rod")


def _turned(pose: np.ndarray, azimuth: float) -> np.ndarray:
    c, s = np.cos(azimuth), np.sin(azimuth)
    turn = np.eye(4)
    turn[:2, :2] = [[c, -s], [s, c]]
    return turn @ pose


def _item(kind: str, mesh: Mesh, pose: np.ndarray, vessel: str, id: int, colour: float) -> SceneObject:
    name = f"{kind.replace(' ', '-')}-{id:02d}"
    centre = mesh.bounds.mean(0)
    centred = replace(mesh, name=name, vertices=mesh.vertices.astype(np.float64) - centre)
    x, y, z = np.ptp(centred.bounds, axis=0).tolist()
    world_T_object = pose.copy()
    world_T_object[:3, 3] += pose[:3, :3] @ centre
    common = {"id": id, "name": name, "category": kind, "within": vessel, "size": (x, y, z)}
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
