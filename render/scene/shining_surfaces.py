"""The emitter of a mesh that shines by itself, in the colours of a picture.

Mitsuba's own area emitter samples a picture by its pixels and looks for their places by texture coordinates, which
needs coordinates that no two places of the mesh share; those of people's files do. This one samples the surface evenly.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from ...procedural.description.material import Emission
from ...procedural.materials.textures import bake
from .._mitsuba import dr, mi
from .spectrum import in_channel


def surface_emitter(emission: Emission, channel: int | None = None) -> mi.Emitter:
    """Return the emitter of a mesh whose material has an emission."""
    bitmap = mi.Bitmap(np.array(in_channel(bake(emission.colour), channel), np.float32, order="C"))
    tint = mi.load_dict({"type": "bitmap", "bitmap": bitmap, "raw": False, "filter_type": "bilinear"})
    return _emitter_class(mi.variant())(tint, emission.radiance)


@cache
def _emitter_class(variant: str) -> Any:
    """Return the class of a variant: the types of Mitsuba are others in each."""

    class ShiningSurface(mi.Emitter):
        """A surface with a radiance that does not depend on the direction, on its front side alone."""

        def __init__(self, tint: mi.Texture, radiance: float) -> None:
            super().__init__(mi.Properties())
            self.tint, self.radiance = tint, dr.opaque(mi.Float, radiance)
            self.white = mi.load_dict({"type": "d65"})  # as that of lamps; 1 in RGB variants
            self.m_flags = mi.EmitterFlags.Surface | mi.EmitterFlags.SpatiallyVarying

        def eval(self, si: mi.SurfaceInteraction3f, active: mi.Bool = True) -> mi.Spectrum:
            front = active & (mi.Frame3f.cos_theta(si.wi) > 0.0)
            return dr.select(front, self.sent(si, front), 0.0)

        def sent(self, si: mi.SurfaceInteraction3f, active: mi.Bool) -> mi.Spectrum:
            return self.radiance * self.white.eval(si, active) * self.tint.eval(si, active)

        def sample_direction(
            self, it: mi.Interaction3f, sample: mi.Point2f, active: mi.Bool = True
        ) -> tuple[mi.DirectionSample3f, mi.Spectrum]:
            ds = self.get_shape().sample_direction(it, sample, active)
            front = active & (dr.dot(ds.d, ds.n) < 0.0) & (ds.pdf > 0.0)
            ds.emitter = mi.EmitterPtr(self)
            si = dr.zeros(mi.SurfaceInteraction3f)
            si.uv, si.wavelengths = ds.uv, it.wavelengths
            return ds, dr.select(front, self.sent(si, front) / ds.pdf, 0.0)

        def pdf_direction(self, it: mi.Interaction3f, ds: mi.DirectionSample3f, active: mi.Bool = True) -> mi.Float:
            front = active & (dr.dot(ds.d, ds.n) < 0.0)
            return dr.select(front, self.get_shape().pdf_direction(it, ds, front), 0.0)

        def to_string(self) -> str:
            return f"ShiningSurface[{variant}]"

    return ShiningSurface
