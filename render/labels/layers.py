"""K layers: the surfaces along straight rays, written down by the ray loop of `geometry.straight`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...procedural.description.scene import Prop, materials_of
from .._mitsuba import dr, mi
from ..frame import Layers
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import Pinhole
from ..scene.surfaces import SurfaceTable, registry_id

# A layer's small numbers share one 32-bit word: 16 bits of id, 2 of part, 1 of entering, 13 of material.
_PART_AT, _ENTERING_AT, _MATERIAL_AT = 16, 18, 19


@dataclass(frozen=True, eq=False)
class Recorder:
    """Where a ray loop puts the layers of `rays` rays: layer by layer, `count` of them."""

    count: mi.UInt32
    rays: mi.UInt32
    lane: mi.UInt32
    front: mi.UInt32  #: material before a surface, by registry id
    back: mi.UInt32  #: material behind it
    depth_per_distance: mi.Float
    world_R_camera: mi.Matrix3f
    distance: mi.Float
    normal: tuple[mi.Float16, mi.Float16, mi.Float16]
    word: mi.UInt32


def recorder(kernel: LoadedScene, view: Pinhole, depth_per_distance: mi.Float, count: int) -> Recorder:
    """Return an empty record of the first `count` surfaces along each ray of one eye."""
    rays = dr.width(depth_per_distance)
    front, back = _materials_by_row(kernel)
    size = max(count * rays, 1)
    word = dr.zeros(mi.UInt32, size)
    distance = dr.full(mi.Float, np.inf, size)
    normal = (dr.zeros(mi.Float16, size), dr.zeros(mi.Float16, size), dr.zeros(mi.Float16, size))
    dr.eval(depth_per_distance, distance, normal, word)
    return Recorder(
        count=dr.opaque(mi.UInt32, count),
        rays=dr.opaque(mi.UInt32, rays),
        lane=dr.arange(mi.UInt32, rays),
        front=front,
        back=back,
        depth_per_distance=depth_per_distance,
        world_R_camera=view.world_R_camera,
        distance=distance,
        normal=normal,
        word=word,
    )


def record(
    into: Recorder | None,
    table: SurfaceTable,
    layer: mi.UInt32,
    si: mi.SurfaceInteraction3f,
    ray: mi.Ray3f,
    distance: mi.Float,
    active: mi.Bool,
) -> None:
    """Write the surface that each ray meets down as its `layer`, `distance` [m] from the camera; None takes none."""
    if into is None:
        return
    active = active & (layer < into.count)
    row = registry_id(si.shape)
    entering = dr.dot(si.n, ray.d) < 0.0
    front, back = dr.gather(mi.UInt32, into.front, row, active), dr.gather(mi.UInt32, into.back, row, active)
    word = dr.gather(mi.UInt32, table.instance, row, active)
    word |= dr.gather(mi.UInt32, table.part, row, active) << _PART_AT
    word |= dr.select(entering, mi.UInt32(1 << _ENTERING_AT), mi.UInt32(0))
    word |= dr.select(entering, back, front) << _MATERIAL_AT
    n = si.sh_frame.n
    facing = into.world_R_camera.T @ mi.Vector3f(dr.select(dr.dot(n, ray.d) > 0.0, -n, n))
    at = layer * into.rays + into.lane
    dr.scatter(into.distance, distance * into.depth_per_distance, at, active)
    dr.scatter(into.word, word, at, active)
    for axis in range(3):
        dr.scatter(into.normal[axis], mi.Float16(facing[axis]), at, active)


def layers_of(made: Recorder, met: mi.UInt32, shape: tuple[int, int]) -> Layers:
    """Return the record of the rays through the pixels of one picture, `met` the surfaces of each ray."""
    count = int(made.count[0])
    every = (count, *shape)

    def stored(values: mi.Float | mi.UInt32) -> np.ndarray:
        return np.array(values)[: count * shape[0] * shape[1]].reshape(every)

    word = stored(made.word)
    return Layers(
        Z=stored(made.distance),
        normal=np.stack([stored(axis) for axis in made.normal], axis=-1),
        id=(word & 0xFFFF).astype(np.uint16),
        part=(word >> _PART_AT & 0b11).astype(np.uint8),
        material=(word >> _MATERIAL_AT).astype(np.uint16),
        entering=(word >> _ENTERING_AT & 1).astype(bool),
        count=np.array(met).astype(np.uint16).reshape(shape),
    )


def _materials_by_row(kernel: LoadedScene) -> tuple[mi.UInt32, mi.UInt32]:
    """Return the material before and behind each surface, by registry id; before an opaque one is air."""
    scene, table = kernel.description, kernel.surfaces
    materials = materials_of(scene)
    media = np.array([materials.index(medium) for medium in table.media], np.uint32)
    solids = [materials.index(item.material) if isinstance(item, Prop) else 0 for item in scene.objects]
    solids = np.array([*solids, materials.index(scene.table.material)], np.uint32)  # the table is object -1
    opaque = np.array(table.opaque)
    front = np.where(opaque, 0, media[np.array(table.front)]).astype(np.uint32)
    back = np.where(opaque, solids[np.array(table.object)], media[np.array(table.back)]).astype(np.uint32)
    front, back = mi.UInt32(front), mi.UInt32(back)
    dr.make_opaque(front, back)
    return front, back
