"""How surfaces look in programs that know no textures of ours: one colour, and how much light passes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....core.images import srgb_curve
from ....core.mesh import Mesh
from ....procedural.description.material import OpaqueMaterial
from ....procedural.materials.surface_maps import mean_metallic, mean_roughness
from ....procedural.optics.medium import Medium
from ....procedural.patterns.bake import bake_material

#: Length for which the colour of a medium is stated [m]: about what a ray crosses in a glass of water.
SEEN_LENGTH = 0.02
#: Opacity of transparent bodies where a program has no refraction [1]: low enough to see what is behind several walls,
#: high enough to see the body.
CLEAR_OPACITY = 0.25


@dataclass(frozen=True)
class Look:
    """The look of a surface."""

    name: str
    colour: tuple[float, float, float]  #: linear Rec.709, in [0, 1]
    roughness: float  #: of the principled model, the root of GGX alpha
    metallic: float = 0.0
    opacity: float = 1.0
    eta: float | None = None  #: refractive index at the d line; None for opaque surfaces


def opaque_look(material: OpaqueMaterial, mesh: Mesh) -> Look:
    """Return the mean look of an opaque material on a mesh."""
    if material.base_colour.kind == "vertices" and mesh.colours is not None:
        reflectance = mesh.colours[np.unique(mesh.faces)]
    else:
        reflectance = bake_material(material)[0].reshape(-1, 3)
    return Look(
        name=material.name,
        colour=_colour(np.mean(reflectance, axis=0, dtype=np.float64)),
        roughness=float(np.clip(mean_roughness(material), 0.0, 1.0)),
        metallic=float(np.clip(mean_metallic(material), 0.0, 1.0)),
    )


def medium_look(medium: Medium, roughness: float) -> Look:
    """Return the look of a transparent body; `roughness` is GGX alpha."""
    passed = np.exp(-np.array(medium.sigma_a) * SEEN_LENGTH)
    return Look(medium.name, _colour(passed), roughness**0.5, opacity=CLEAR_OPACITY, eta=medium.eta)


def shown_colour(look: Look) -> tuple[float, float, float]:
    """Return the colour encoded for displays (sRGB), as programs take it that shade without linear colours."""
    red, green, blue = srgb_curve(np.array(look.colour)).tolist()
    return red, green, blue


def _colour(values: np.ndarray | np.floating) -> tuple[float, float, float]:
    red, green, blue = np.clip(values, 0.0, 1.0).tolist()
    return red, green, blue
