"""Opaque materials: description -> Mitsuba's principled BSDF."""

from __future__ import annotations

import mitsuba as mi
import numpy as np

from ..procedural.materials.description import OpaqueMaterial
from ..procedural.materials.textures import bake


def opaque_bsdf(material: OpaqueMaterial) -> dict:
    """Return the dictionary of a two-sided principled BSDF.

    Every material has a bitmap for its colour, even a plain one: all opaque surfaces then share one kernel, and a new
    scene with other numbers compiles nothing.
    """
    colour = {
        "type": "bitmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(bake(material.base_colour), dtype=np.float32)),
        "raw": False,  # reflectance, for spectral variants too; a float bitmap counts as linear
        "filter_type": "bilinear",
        "wrap_mode": "repeat",
        "to_uv": mi.ScalarTransform3f().scale([material.repeats, material.repeats]),
    }
    principled = {
        "type": "principled",
        "base_color": colour,
        "roughness": material.roughness,
        "metallic": material.metallic,
    }
    return {"type": "twosided", "bsdf": principled}
