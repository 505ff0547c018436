"""Surface table: per-shape columns (ids, media on both sides, roughness) that the ray loops read by registry id."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...procedural.optics.medium import AIR, Medium
from .._mitsuba import dr, mi
from ..frame import PARTS
from .spectrum import absorption_at, index_at, media_columns
from .surface_maps import SurfaceMaps, surface_maps

#: Index of air in every table of media.
AIR_INDEX = 0
#: In place of such an index, of segments that shading normals lead into an opaque body: no medium is there.
BURIED = 0xFFFFFFFF
#: `Surface.object` of a room's surfaces and lamps.
ROOM_OBJECT = -3


@dataclass(frozen=True)
class Surface:
    """One shape as the ray loops see it; before an opaque surface is its `front`, such as the liquid around a straw."""

    instance: int  #: instance id; 0 for lights and for a room, which are surroundings
    object: int  #: position in `Scene.objects`, -1 for the table and the lights, `ROOM_OBJECT`
    opaque: bool
    front: Medium  #: the medium that the geometric normal points into
    back: Medium
    alpha: float  #: GGX roughness of an interface
    part: str = PARTS[0]  #: one of `PARTS`
    polished: bool = False  #: whether it is a prop with clear mirror reflections
    candidates: int = 1  #: samples of emitter sampling of which one is followed, in pictures
    piece: int = 0  #: number of the part of a prop, or of the material of a room's surface
    label: int | None = None  #: id in labels, where it is not `instance`


@dataclass(eq=False)  # not frozen: Dr.Jit assigns to the fields of loop state
class SurfaceMedia:
    """The surface at the end of a ray's segment: the media on both sides and the normals on the ray's side."""

    row: mi.UInt32  #: registry id, row of the surface table
    opaque: mi.Bool
    before: mi.UInt32  #: index of the medium on the ray's side, which fills the segment; air where nothing is hit
    behind: mi.UInt32  #: index of the medium on the other side
    n: mi.Normal3f  #: geometric normal on the ray's side
    ns: mi.Normal3f  #: shading normal, with the same sign as the geometric one
    distance: mi.Float  #: length of the segment [m]; 0 where nothing is hit


@dataclass(frozen=True, eq=False)
class SurfaceTable:
    """Columns of the table, Dr.Jit arrays indexed by registry id, and the optics of the media that they refer to.

    Labels use the index at the d line and the absorption in linear Rec.709 (columns `eta_d`, `sigma_a_rgb`) in every
    variant. Pictures use the columns `eta_render` and `sigma_a_render`, sampled for the active variant (RGB, grey or a
    grid of wavelengths), through `relative_index` and `transmittance`.
    """

    instance: mi.UInt32
    label: mi.UInt32  #: the id in labels: that of the instance, or of a part of the room
    object: mi.Int32
    opaque: mi.Bool
    front: mi.UInt32
    back: mi.UInt32  #: of opaque surfaces that before them: rays that shading normals lead into them end there as well
    behind: mi.UInt32  #: the medium behind, also behind the opaque surface of a turbid liquid
    alpha: mi.Float
    part: mi.UInt32  #: index into `PARTS`
    polished: mi.Bool
    piece: mi.UInt32
    eta_d: mi.Float  #: by medium: refractive index at the d line
    sigma_a_rgb: mi.Float  #: by medium and linear Rec.709 channel, 3 values each: absorption [1/m]
    eta_render: mi.Float  #: by medium and sample of the active variant (`spectrum.index_at`)
    sigma_a_render: mi.Float  #: by medium and sample of the active variant (`spectrum.absorption_at`) [1/m]
    media: tuple[Medium, ...]
    maps: SurfaceMaps | None = None  #: of roughness, metalness and normals; None where no material has any
    #: Samples of emitter sampling (`emitter_candidates`); None where all surfaces have one: the kernels of such scenes
    #: know nothing of more.
    candidates: mi.UInt32 | None = None

    def relative_index(self, surface: SurfaceMedia, wavelengths: Any) -> mi.Float:
        """Return the index behind an interface over the index before it, for pictures in the active variant."""
        behind = index_at(self.eta_render, surface.behind, wavelengths, mi.Bool(True))
        return behind / index_at(self.eta_render, surface.before, wavelengths, mi.Bool(True))

    def transmittance(self, surface: SurfaceMedia, wavelengths: Any, active: mi.Bool) -> mi.UnpolarizedSpectrum:
        """Return the Beer-Lambert transmittance of the segment that ends at a surface, in the active variant."""
        sigma_a = absorption_at(self.sigma_a_render, surface.before, wavelengths, active)
        return dr.exp(-sigma_a * surface.distance)


def surface_table(
    surfaces: dict[int, Surface],
    dispersion: bool,
    maps: dict[int, np.ndarray] | None = None,
    channel: int | None = None,
    refractivity: float = 1.0,
) -> SurfaceTable:
    """Return the table of the surfaces given by registry id; with dispersion, indices depend on the wavelength.

    The `maps` of materials are given by registry id too (`surface_maps`). The `refractivity` is a factor on the index
    less one in pictures (`Picture.refractivity`).
    """
    media = [AIR]
    for surface in surfaces.values():
        media += [medium for medium in (surface.front, surface.back) if medium not in media]
    rows = [surfaces.get(index) for index in range(max(surfaces) + 1)]
    blank = Surface(0, -1, True, AIR, AIR, 0.0)
    rows = [blank if row is None else row for row in rows]

    index, absorption = media_columns(media, dispersion, channel)
    index = index if refractivity == 1.0 else 1.0 + refractivity * (index - 1.0)
    counts = [row.candidates for row in rows]

    def column(kind: type, values: list | np.ndarray) -> Any:
        array = kind(np.array(values))
        dr.make_opaque(array)
        return array

    return SurfaceTable(
        instance=column(mi.UInt32, [row.instance for row in rows]),
        label=column(mi.UInt32, [row.instance if row.label is None else row.label for row in rows]),
        object=column(mi.Int32, [row.object for row in rows]),
        opaque=column(mi.Bool, [row.opaque for row in rows]),
        front=column(mi.UInt32, [media.index(row.front) for row in rows]),
        back=column(mi.UInt32, [media.index(row.front if row.opaque else row.back) for row in rows]),
        behind=column(mi.UInt32, [media.index(row.back) for row in rows]),
        alpha=column(mi.Float, [row.alpha for row in rows]),
        part=column(mi.UInt32, [PARTS.index(row.part) for row in rows]),
        polished=column(mi.Bool, [row.polished for row in rows]),
        piece=column(mi.UInt32, [row.piece for row in rows]),
        eta_d=column(mi.Float, [medium.eta for medium in media]),
        sigma_a_rgb=column(mi.Float, np.array([medium.sigma_a for medium in media], np.float32).ravel()),
        eta_render=column(mi.Float, index.astype(np.float32).ravel()),
        sigma_a_render=column(mi.Float, absorption.astype(np.float32).ravel()),
        media=tuple(media),
        maps=surface_maps(maps or {}, len(rows)),
        candidates=column(mi.UInt32, counts) if max(counts) > 1 else None,
    )


def registry_id(shape: mi.ShapePtr) -> mi.UInt32:
    """Return the registry id of each shape pointer, the row of the table (0 for null pointers)."""
    return dr.reinterpret_array(mi.UInt32, shape)


def surface_media(table: SurfaceTable, si: mi.SurfaceInteraction3f, ray: mi.Ray3f, hit: mi.Bool) -> SurfaceMedia:
    """Return the media on both sides of the surface that a ray hits: the step that all ray loops share.

    The side is decided by the geometric normal. A ray that hits nothing ends in air.
    """
    row = registry_id(si.shape)
    from_front = dr.dot(si.n, ray.d) < 0.0
    opaque = dr.gather(mi.Bool, table.opaque, row, hit)
    front, back = dr.gather(mi.UInt32, table.front, row, hit), dr.gather(mi.UInt32, table.back, row, hit)
    before = dr.select(hit, dr.select(from_front, front, back), AIR_INDEX)
    behind = dr.select(from_front, back, front)
    sign = dr.select(from_front, mi.Float(1.0), mi.Float(-1.0))
    n, ns, distance = sign * si.n, sign * si.sh_frame.n, dr.select(hit, si.t, 0.0)
    return SurfaceMedia(row, opaque, before, behind, n, ns, distance)


def seen_from_air(surface: SurfaceMedia, first: mi.Bool) -> SurfaceMedia:
    """Return the surface at the end of a segment, before which there is air where it is the `first` one of its ray.

    The eye is in air. At a waterline rays slip between the liquid and what stands in it, and meet that first; its side
    towards them says that they came through the liquid.
    """
    return replace(surface, before=dr.select(first, AIR_INDEX, surface.before))


def medium_at_end(surface: SurfaceMedia, medium: mi.UInt32) -> mi.UInt32:
    """Return the medium of a segment at its end, by the medium at its start.

    It is the one before the surface there; a segment from inside an opaque body stays there, whatever it meets in it,
    such as a spoon in a turbid liquid.
    """
    return dr.select(medium == BURIED, mi.UInt32(BURIED), surface.before)


def medium_after_bounce(front: mi.UInt32, si: mi.SurfaceInteraction3f, direction: mi.Vector3f) -> mi.UInt32:
    """Return the medium of the segment that leaves an opaque surface, or `BURIED` where it leads into the body."""
    return dr.select(dr.dot(si.n, direction) > 0.0, front, mi.UInt32(BURIED))


def medium_after_interface(medium: mi.UInt32, surface: SurfaceMedia, transmitted: mi.Bool) -> mi.UInt32:
    """Return the medium of the segment that leaves an interface, by that of the one that met it (`medium_at_end`).

    Inside an opaque body, such as a painted vessel whose liquid wets its walls, interfaces lead nowhere else.
    """
    crossed = dr.select(transmitted, surface.behind, surface.before)
    return dr.select(medium == BURIED, mi.UInt32(BURIED), crossed)


def broken_continuity(surface: SurfaceMedia, medium: mi.UInt32) -> mi.UInt32:
    """Return 1 where the medium before a surface is not the one that the segment started in, else 0.

    Segments from inside an opaque body count for nothing: only shading normals and hairline cracks lead there. Those
    that meet an opaque surface from behind without having entered it so do count: an interface is missing.
    """
    return dr.select((surface.before != medium) & (medium != BURIED), mi.UInt32(1), mi.UInt32(0))


def transmittance_rgb(sigma_a: mi.Float, surface: SurfaceMedia, active: bool | mi.Bool) -> mi.Color3f:
    """Return the Beer-Lambert transmittance of a segment for labels, by absorption in linear Rec.709 of each medium."""
    return dr.exp(-dr.gather(mi.Color3f, sigma_a, surface.before, active) * surface.distance)


def relative_index_d(eta: mi.Float, surface: SurfaceMedia, active: bool | mi.Bool = True) -> mi.Float:
    """Return the index behind an interface over the index before it for labels, by the index of each medium."""
    # (The divisor is read in all lanes: 0 / 0 in inactive ones would reach derivatives.)
    return dr.gather(mi.Float, eta, surface.behind, active) / dr.gather(mi.Float, eta, surface.before)
