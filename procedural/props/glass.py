"""The medium that a mesh file's transparent material is."""

from __future__ import annotations

import math

from ..mesh_files.model import GlassLook, Look
from ..optics.medium import Medium

#: Least transmittance that is told from black [1].
_LEAST = 1e-4


def medium_of(look: GlassLook, metres_per_unit: float, name: str) -> Medium:
    """Return a file's glass as a medium: where ``colour`` is left after ``distance``, it absorbs its logarithm.

    Parameters
    ----------
    look : GlassLook
        Index, colour and distance, as KHR_materials_ior and KHR_materials_volume of glTF 2.0 state them.
    metres_per_unit : float
        Length of the file's unit [m].
    name : str
        Of the medium.
    """
    length = look.distance * metres_per_unit
    red, green, blue = (0.0 if math.isinf(length) else -math.log(max(c, _LEAST)) / length for c in look.colour)
    return Medium(name=name, eta=look.index, sigma_a=(red, green, blue), source="the mesh file's material")


def roughness_of(look: Look) -> float:
    """Return the GGX alpha of a look: the square of its roughness (glTF 2.0, section 3.9.2); 0 where it has none."""
    return (look.roughness or 0.0) ** 2
