"""K layers (depth peeling): the first surfaces along straight rays, recorded by `geometry.straight_hits`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...procedural.description.material_list import materials_of
from ...procedural.description.scene import Prop
from .._mitsuba import dr, mi
from ..frame import Layers, Transmission
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import Pinhole
from ..scene.surfaces import ROOM_OBJECT, SurfaceTable, registry_id

# A layer's small integers share one 32-bit word: 16 bits of id, 3 of part, 1 of entering, 12 of material.
_PART_SHIFT, _ENTERING_SHIFT, _MATERIAL_SHIFT = 16, 19, 20


@dataclass(frozen=True, eq=False)
class RayHit:
    """Where rays hit surfaces."""

    si: mi.SurfaceInteraction3f
    ray: mi.Ray3f
    distance: mi.Float  #: from the camera, along the ray [m]


@dataclass(frozen=True, eq=False)
class LayerRecorder:
    """Buffers that a ray loop writes the layers of `rays` rays to: layer by layer, `count` of them."""

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
    #: what each surface passes on, and what the segment before it does (three colours); None where it is not wanted
    passed: tuple[mi.Float, mi.Float, mi.Float, mi.Float] | None = None


def layer_recorder(
    loaded: LoadedScene, view: Pinhole, depth_per_distance: mi.Float, count: int, transmission: bool = False
) -> LayerRecorder:
    """Return empty buffers for the first `count` surfaces along each ray of one eye, also for what they pass on."""
    rays = dr.width(depth_per_distance)
    front, back = _materials_by_row(loaded)
    size = max(count * rays, 1)
    word = dr.zeros(mi.UInt32, size)
    distance = dr.full(mi.Float, np.inf, size)
    normal = (dr.zeros(mi.Float16, size), dr.zeros(mi.Float16, size), dr.zeros(mi.Float16, size))
    passed = None
    if transmission:
        passed = (dr.ones(mi.Float, size), dr.ones(mi.Float, size), dr.ones(mi.Float, size), dr.ones(mi.Float, size))
    dr.eval(depth_per_distance, distance, normal, word, passed)
    return LayerRecorder(
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
        passed=passed,
    )


def write_layer(
    recorder: LayerRecorder | None, table: SurfaceTable, layer: mi.UInt32, hit: RayHit, active: mi.Bool
) -> None:
    """Write the surface that each ray hits to the buffers of its `layer`, unless all layers are full or None exist."""
    # (The check is here because Dr.Jit would turn one in the ray loop into a symbolic branch.)
    if recorder is None:
        return
    si, ray = hit.si, hit.ray
    active = active & (layer < recorder.count)
    row = registry_id(si.shape)
    entering = dr.dot(si.n, ray.d) < 0.0
    front, back = dr.gather(mi.UInt32, recorder.front, row, active), dr.gather(mi.UInt32, recorder.back, row, active)
    word = dr.gather(mi.UInt32, table.label, row, active)
    word |= dr.gather(mi.UInt32, table.part, row, active) << _PART_SHIFT
    word |= dr.select(entering, mi.UInt32(1 << _ENTERING_SHIFT), mi.UInt32(0))
    word |= dr.select(entering, back, front) << _MATERIAL_SHIFT
    n = si.sh_frame.n
    facing = recorder.world_R_camera.T @ mi.Vector3f(dr.select(dr.dot(n, ray.d) > 0.0, -n, n))
    at = layer * recorder.rays + recorder.lane
    dr.scatter(recorder.distance, hit.distance * recorder.depth_per_distance, at, active)
    dr.scatter(recorder.word, word, at, active)
    for axis in range(3):
        dr.scatter(recorder.normal[axis], mi.Float16(facing[axis]), at, active)


def write_transmission(
    recorder: LayerRecorder | None, layer: mi.UInt32, surface: mi.Float, segment: mi.Color3f, active: mi.Bool
) -> None:
    """Write what the surface that each ray hits passes on, and the segment before it, unless nobody wants to know."""
    if recorder is None or recorder.passed is None:
        return
    active = active & (layer < recorder.count)
    at = layer * recorder.rays + recorder.lane
    for buffer, value in zip(recorder.passed, (surface, segment.x, segment.y, segment.z), strict=True):
        dr.scatter(buffer, value, at, active)


def recorded_transmission(recorder: LayerRecorder) -> Transmission:
    """Return what the recorded surfaces of all rays pass on."""
    assert recorder.passed is not None
    count, rays = int(recorder.count[0]), int(recorder.rays[0])

    def stored(values: mi.Float | mi.UInt32) -> np.ndarray:
        return np.array(values)[: count * rays].reshape(count, rays)

    word = stored(recorder.word)
    surface, *segment = (stored(values) for values in recorder.passed)
    return Transmission(
        id=(word & 0xFFFF).astype(np.uint16),
        material=(word >> _MATERIAL_SHIFT).astype(np.uint16),
        surface=surface,
        segment=np.stack(segment, axis=-1),
    )


def recorded_layers(recorder: LayerRecorder, surfaces: mi.UInt32, shape: tuple[int, int]) -> Layers:
    """Return the layers of the rays through the pixels of one picture, and the number of surfaces of each ray."""
    count = int(recorder.count[0])
    every = (count, *shape)

    def stored(values: mi.Float | mi.UInt32) -> np.ndarray:
        return np.array(values)[: count * shape[0] * shape[1]].reshape(every)

    word = stored(recorder.word)
    return Layers(
        Z=stored(recorder.distance),
        normal=np.stack([stored(axis) for axis in recorder.normal], axis=-1),
        id=(word & 0xFFFF).astype(np.uint16),
        part=(word >> _PART_SHIFT & 0b111).astype(np.uint8),
        material=(word >> _MATERIAL_SHIFT).astype(np.uint16),
        entering=(word >> _ENTERING_SHIFT & 1).astype(bool),
        count=np.array(surfaces).astype(np.uint16).reshape(shape),
    )


def _materials_by_row(loaded: LoadedScene) -> tuple[mi.UInt32, mi.UInt32]:
    """Return the material before and behind each surface, by registry id."""
    scene, table = loaded.description, loaded.surfaces
    materials = materials_of(scene)
    media = np.array([materials.index(medium) for medium in table.media], np.uint32)
    # The table is object -1; the room has no material among those of the scene and counts as air.
    solids = {-1: [materials.index(scene.table.material)], ROOM_OBJECT: [0]}
    for number, item in enumerate(scene.objects):
        solids[number] = [materials.index(piece.material) for piece in item.pieces] if isinstance(item, Prop) else [0]
    rows = zip(np.array(table.object).tolist(), np.array(table.piece).tolist(), strict=True)
    solid = np.array([solids[number][piece] for number, piece in rows], np.uint32)
    opaque = np.array(table.opaque)
    front = media[np.array(table.front)].astype(np.uint32)
    # A turbid liquid is opaque, but what is behind its surface is the liquid.
    back = np.where(opaque & (np.array(table.part) == 0), solid, media[np.array(table.behind)]).astype(np.uint32)
    front, back = mi.UInt32(front), mi.UInt32(back)
    dr.make_opaque(front, back)
    return front, back
