"""Opaque materials: description -> Mitsuba's principled BSDF."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...core.mesh import Mesh
from ...procedural.description.material import OpaqueMaterial
from ...procedural.materials.textures import bake
from .._mitsuba import mi


def opaque_bsdf(material: OpaqueMaterial) -> dict:
    """Return the dictionary of a principled BSDF, seen from its front; the ray loop turns it to the ray.

    Every material has a bitmap for its colour, even a plain one: all opaque surfaces then share one kernel, and a new
    scene with other numbers compiles nothing. For the same reason the repeats are not the bitmap's: see `repeated`.
    """
    colour = {
        "type": "bitmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(bake(material.base_colour), dtype=np.float32)),
        "raw": False,  # reflectance, for spectral variants too; a float bitmap counts as linear
        "filter_type": "bilinear",
        "wrap_mode": "repeat",
    }
    return {
        "type": "principled",
        "base_color": colour,
        "roughness": material.roughness,
        # As a texture: Mitsuba compiles another BSDF for the number 0 than for others.
        "metallic": {"type": "uniform", "value": material.metallic},
    }


def repeated(mesh: Mesh, material: OpaqueMaterial) -> Mesh:
    """Return the mesh with texture coordinates that repeat the colour as often as the material says.

    Mitsuba's own transform of texture coordinates would stand in the kernel as a literal.
    """
    return mesh if mesh.uv is None or material.repeats == 1.0 else replace(mesh, uv=mesh.uv * material.repeats)
