"""What each surface parts: per-shape tables that the ray loops read by the shape's registry id."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...procedural.optics.medium import AIR, Medium
from .._mitsuba import dr, mi
from ..frame import PARTS
from .spectrum import media_columns

#: Index of air in every table of media.
AIR_INDEX = 0


@dataclass(frozen=True)
class Surface:
    """One shape as the ray loops see it. `front` and `back` are equal for opaque surfaces."""

    instance: int  #: instance id; 0 for lights
    object: int  #: position in `Scene.objects`, or -1 for the table and the lights
    opaque: bool
    front: Medium  #: the medium that the geometric normal points into
    back: Medium
    alpha: float  #: GGX roughness of an interface
    part: str = PARTS[0]  #: one of `PARTS`
    polished: bool = False  #: whether it is a prop that mirrors clearly


@dataclass(frozen=True, eq=False)
class SurfaceTable:
    """Columns of the table, Dr.Jit arrays indexed by registry id, and the media that they refer to."""

    instance: mi.UInt32
    object: mi.Int32
    opaque: mi.Bool
    front: mi.UInt32
    back: mi.UInt32
    alpha: mi.Float
    part: mi.UInt32  #: index into `PARTS`
    polished: mi.Bool
    eta: mi.Float  #: by medium, at the d line: what labels use
    sigma_a: mi.Float  #: by medium and linear Rec.709 colour, 3 numbers each [1/m]: what labels use
    index: mi.Float  #: by medium, for pictures in the active variant (`spectrum.index_at`)
    absorption: mi.Float  #: by medium, for pictures in the active variant [1/m] (`spectrum.absorption_at`)
    media: tuple[Medium, ...]


def surface_table(surfaces: dict[int, Surface], dispersion: bool) -> SurfaceTable:
    """Return the table of the surfaces given by registry id; with dispersion, indices follow the wavelength."""
    media = [AIR]
    for surface in surfaces.values():
        media += [medium for medium in (surface.front, surface.back) if medium not in media]
    rows = [surfaces.get(index) for index in range(max(surfaces) + 1)]
    blank = Surface(0, -1, True, AIR, AIR, 0.0)
    rows = [blank if row is None else row for row in rows]

    index, absorption = media_columns(media, dispersion)

    def column(kind: type, values: list | np.ndarray) -> Any:
        array = kind(np.array(values))
        dr.make_opaque(array)
        return array

    return SurfaceTable(
        instance=column(mi.UInt32, [row.instance for row in rows]),
        object=column(mi.Int32, [row.object for row in rows]),
        opaque=column(mi.Bool, [row.opaque for row in rows]),
        front=column(mi.UInt32, [media.index(row.front) for row in rows]),
        back=column(mi.UInt32, [media.index(row.back) for row in rows]),
        alpha=column(mi.Float, [row.alpha for row in rows]),
        part=column(mi.UInt32, [PARTS.index(row.part) for row in rows]),
        polished=column(mi.Bool, [row.polished for row in rows]),
        eta=column(mi.Float, [medium.eta for medium in media]),
        sigma_a=column(mi.Float, np.array([medium.sigma_a for medium in media], np.float32).ravel()),
        index=column(mi.Float, index.astype(np.float32).ravel()),
        absorption=column(mi.Float, absorption.astype(np.float32).ravel()),
        media=tuple(media),
    )


def registry_id(shape: mi.ShapePtr) -> mi.UInt32:
    """Return the registry id of each shape pointer, the row of the table (0 where there is none)."""
    return dr.reinterpret_array(mi.UInt32, shape)


def met(
    table: SurfaceTable, si: mi.SurfaceInteraction3f, ray: mi.Ray3f, hit: mi.Bool
) -> tuple[mi.Bool, mi.UInt32, mi.UInt32, mi.Normal3f, mi.Normal3f]:
    """Return of the surface met: whether it is opaque, the media before and behind it, and its normals.

    Geometric and shading normal are on the side that the ray comes from, by the geometric one. A ray that meets nothing
    ends in air.
    """
    row = registry_id(si.shape)
    from_front = dr.dot(si.n, ray.d) < 0.0
    opaque = dr.gather(mi.Bool, table.opaque, row, hit)
    front, back = dr.gather(mi.UInt32, table.front, row, hit), dr.gather(mi.UInt32, table.back, row, hit)
    facing = dr.select(hit, dr.select(from_front, front, back), AIR_INDEX)
    sign = dr.select(from_front, mi.Float(1.0), mi.Float(-1.0))
    return opaque, facing, dr.select(from_front, back, front), sign * si.n, sign * si.sh_frame.n
