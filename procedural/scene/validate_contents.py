"""Whether what is in a vessel can be there: interfaces with their media, closed bodies, volumes and levels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...core.errors import InputError
from ...core.mesh import Mesh, check_closed, on_border, volume_of
from ..description.refill import ring_segments
from ..description.scene import (
    GlassBody,
    Interface,
    Liquid,
    MeshVessel,
    Scene,
    Vessel,
    content_solid,
    glass_solid,
    liquid_solid,
)
from ..description.standing import Standing, standing_in
from ..optics.medium import AIR
from ..profiles.liquid import brimful_volume, level_of_volume

#: Largest relative difference between a liquid's volume and that of its body, of rings that are counted as circles
#: (`_of_circles`): profiles of the coarsest meshes cut off most of that.
VOLUME_TOLERANCE = 0.01
#: Largest distance between a mesh's bounds and the box that `size` states [m]: below what a depth picture can show.
SIZE_TOLERANCE = 1e-4
#: Distance from the wall within which the border of a surface lies on it [m]: bodies keep 20 times as far from it.
_ON_WALL = 5e-6


def check_parts(body: GlassBody) -> None:
    """Refuse a body whose interfaces are not those of the liquids and the bodies in it."""
    found = sorted(part.part for part in body.interfaces if part.part != "content")
    count = len(body.liquids)
    expected = ["outside"]
    if count:
        expected = [*["liquid_interface"] * (count - 1), "liquid_surface", "outside", *["wet_wall"] * count]
    if body.within is not None:  # one piece for each medium around it
        expected, found = ["outside"], sorted(set(found))
    if found != expected:
        raise InputError(body.name, f"the interfaces {', '.join(expected)}", ", ".join(found) or "none")
    if body.layers and body.liquid is None:
        raise InputError(f"{body.name}, layers", "a liquid under them", "none")
    numbers = {part.content for part in body.interfaces if part.part == "content"}
    if numbers != set(range(len(body.contents))):
        raise InputError(f"{body.name}, contents", f"surfaces of {len(numbers)} bodies", len(body.contents))


def check_contents(scene: Scene, body: GlassBody) -> None:
    """Refuse interfaces that differ from the fields of their body, or do not close it, and wrong volumes and levels."""
    places = {"wet_wall": 0, "liquid_interface": 0}
    for part in body.interfaces:
        number = places.get(part.part, 0)
        places[part.part] = number + 1
        _check_sides(body, part, number)
        roughness = body.roughness if part.part in ("outside", "wet_wall") else 0.0
        if part.roughness != roughness:
            where = f"{body.name}, {part.part}, roughness"
            raise InputError(where, f"{roughness:g}, as its body says", f"{part.roughness:g}")
    check_closed(f"{body.name}, glass", glass_solid(body))
    others = standing_in(scene.objects, body)
    for number in range(len(body.contents)):
        _check_content(body, number)
    for number in range(len(body.liquids)):
        _check_liquid(body, number, others)


def _check_sides(body: GlassBody, part: Interface, number: int) -> None:
    """Refuse an interface whose media are not those of its body; it is the `number`-th of its part, from the floor."""
    liquids = [(_named(k), liquid.medium) for k, liquid in enumerate(body.liquids)]
    glass, air = ("the body's glass", body.glass), ("air", AIR)
    if part.part == "content":
        kind = body.contents[part.content or 0]
        around = [air, *liquids]
        front = next((one for one in around if one[1] == part.front), around[-1])
        sides = front, (f"that of its {kind.kind}", kind.medium)
    elif part.part == "outside":
        sides = (air if body.within is None else ("the medium around it", part.front)), glass
    elif part.part == "wet_wall":
        sides = liquids[number], glass
    elif part.part == "liquid_interface":
        sides = liquids[number + 1], liquids[number]
    else:
        sides = air, liquids[-1]
    for side, (what, medium) in zip(("front", "back"), sides, strict=True):
        found = getattr(part, side)
        if found != medium:
            same_name = f"{found.name} with other constants" if found.name == medium.name else found.name
            raise InputError(f"{body.name}, {part.part}, {side}", f"{what} ({medium.name})", same_name)


def _named(number: int) -> str:
    return "its liquid" if number == 0 else f"its layer {number}"


def _check_content(body: GlassBody, number: int) -> None:
    content, solid = body.contents[number], content_solid(body, number)
    where = f"{body.name}, contents, {content.kind} {number}"
    check_closed(where, solid)
    box = np.array([content.centre]) + 0.5 * np.array([[-1.0], [1.0]]) * np.array([content.size])
    if not np.abs(solid.bounds - box).max() <= SIZE_TOLERANCE:
        raise InputError(where, "the middle and the size of its surface", f"{content.centre} and {content.size}")
    volume = volume_of(solid)
    if not abs(content.volume - volume) <= VOLUME_TOLERANCE * volume:
        raise InputError(f"{where}, volume", f"that of its surface, {volume:.4g} m^3", f"{content.volume:.4g} m^3")


def _check_liquid(body: GlassBody, number: int, others: Sequence[Standing]) -> None:
    liquid, top = body.liquids[number], _tops(body)[number]
    where = f"{body.name}, {'liquid' if number == 0 else f'layer {number}'}"
    solid = liquid_solid(body, number, [piece for other in others for piece in other.pieces])
    check_closed(where, solid)
    up = np.array(liquid.up or (0.0, 0.0, 1.0))
    rim = body.inner[-1][1] if isinstance(body, Vessel) else float((glass_solid(body).vertices @ up).max())
    highest = max(liquid.contact, liquid.level, float((top.vertices @ up).max()))
    if highest > rim:
        raise InputError(where, f"a surface below the rim at {rim:.4f} m", f"{highest:.4f} m")
    volume = volume_of(solid) / _of_circles(body)
    if not abs(liquid.volume - volume) <= VOLUME_TOLERANCE * volume:
        raise InputError(f"{where}, volume", f"that of its body, {volume:.4g} m^3", f"{liquid.volume:.4g} m^3")
    _check_heights(body, number, top, others)


def _of_circles(body: GlassBody) -> float:
    """Return the area of a body's rings over that of the circles around them [1]: n sin(2 pi / n) / (2 pi)."""
    if not isinstance(body, Vessel):
        return 1.0
    return float(np.sinc(2.0 / ring_segments(body)))  # sinc(x) = sin(pi x) / (pi x)


def _tops(body: GlassBody) -> list[Mesh]:
    return [part.mesh for part in body.interfaces if part.part in ("liquid_interface", "liquid_surface")]


def _check_heights(body: GlassBody, number: int, surface: Mesh, others: Sequence[Standing]) -> None:
    """Refuse a record of a liquid that differs from its surface, or from what the vessel's profile holds."""
    liquid = body.liquids[number]
    where = f"{body.name}, {'liquid' if number == 0 else f'layer {number}'}"
    if isinstance(body, MeshVessel):
        _check_mesh_heights(where, liquid, surface, bool(body.contents or others))
        return
    stated = {"contact": liquid.contact, "centre": liquid.centre}
    pierced = bool(body.contents or others)  # bodies may take the middle of the surface
    found = {"contact": _rim_height(surface, np.array(body.inner) if isinstance(body, Vessel) else None)}
    if not pierced:
        found["centre"] = surface.vertices[np.hypot(*surface.vertices[:, :2].T).argmin(), 2]
    if isinstance(body, Vessel):
        inner = np.array(body.inner)
        if pierced:  # the volume below the level is that of the liquids and of what is in them
            low, high = surface.vertices[:, 2].min(), surface.vertices[:, 2].max()
            if not low - SIZE_TOLERANCE <= liquid.level <= high + SIZE_TOLERANCE:
                expected = f"one between those of its surface, {low:.4f} to {high:.4f} m"
                raise InputError(f"{where}, level", expected, f"{liquid.level:.4f} m")
        else:
            stated |= {"level": liquid.level}
            total = sum(one.volume for one in body.liquids[: number + 1])
            found |= {"level": level_of_volume(inner, total)}
        fill = liquid.volume / brimful_volume(inner)
        if not abs(liquid.fill - fill) <= VOLUME_TOLERANCE:
            raise InputError(f"{where}, fill", f"that of its volume, {fill:.3f}", f"{liquid.fill:.3f}")
    elif not body.symmetric:
        return
    for field, height in found.items():
        if not abs(stated[field] - height) <= SIZE_TOLERANCE:
            raise InputError(f"{where}, {field}", f"that of its surface, {height:.4f} m", f"{stated[field]:.4f} m")


def _check_mesh_heights(where: str, liquid: Liquid, surface: Mesh, pierced: bool) -> None:
    """Refuse a record that differs from the liquid's surface, which has a piece in each cavity, along what is up."""
    up = np.array(liquid.up or (0.0, 0.0, 1.0))
    rows = [("contact", _border(surface) @ up)]
    rows += [] if pierced else [("centre", surface.vertices @ up)]
    for field, heights in rows:
        stated = getattr(liquid, field)
        nearest = float(heights[np.abs(heights - stated).argmin()])
        if not abs(nearest - stated) <= SIZE_TOLERANCE:
            raise InputError(f"{where}, {field}", f"that of its surface, {nearest:.4f} m", f"{stated:.4f} m")
    low, high = sorted((liquid.centre, liquid.contact))
    if not low - SIZE_TOLERANCE <= liquid.level <= high + SIZE_TOLERANCE:
        expected = f"that of its surface, {low:.4f} to {high:.4f} m"
        raise InputError(f"{where}, level", expected, f"{liquid.level:.4f} m")


def _rim_height(surface: Mesh, inner: np.ndarray | None) -> float:
    """Return the mean height of a surface's border, where it meets the wall; under a neck it is not the widest ring.

    With the profile of the inside, borders around bodies in the liquid are left out.
    """
    border = _border(surface).astype(np.float64)
    if inner is not None:
        away = np.abs(np.hypot(border[:, 0], border[:, 1]) - np.interp(border[:, 2], inner[:, 1], inner[:, 0]))
        border = border[away < _ON_WALL] if (away < _ON_WALL).any() else border
    return float(border[:, 2].mean())


def _border(surface: Mesh) -> np.ndarray:
    """Return the points on a surface's border, (n, 3) [m]."""
    return np.unique(surface.vertices[on_border(surface)], axis=0)
