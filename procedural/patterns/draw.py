"""Materials with a pattern, drawn at random: which surface, in which colours, how worn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...core.model import Reflectance
from ..description.material import OpaqueMaterial, SurfacePattern, SurfaceTexture, UniformTexture
from ..materials.draw import METALS, SEED_END, dielectric, paint_colour, specimen

#: Texels along a side of a surface of a prop [px].
SIDE = 256
#: Colours of woods from early to late wood, matched by eye to planed specimens, linear Rec.709.
WOODS: dict[str, tuple[Reflectance, Reflectance]] = {
    "oak": ((0.46, 0.29, 0.145), (0.19, 0.098, 0.042)),
    "walnut": ((0.175, 0.090, 0.046), (0.050, 0.024, 0.014)),
    "beech": ((0.58, 0.385, 0.23), (0.33, 0.19, 0.10)),
    "pine": ((0.66, 0.47, 0.26), (0.40, 0.21, 0.085)),
    "ash": ((0.62, 0.47, 0.31), (0.35, 0.22, 0.12)),
    "cherry": ((0.42, 0.205, 0.105), (0.22, 0.088, 0.042)),
    "maple": ((0.70, 0.53, 0.36), (0.50, 0.33, 0.19)),
}
#: Print: white and cream papers, and inks that are common on packages, linear Rec.709.
PAPERS: tuple[Reflectance, ...] = ((0.78, 0.76, 0.72), (0.70, 0.63, 0.48), (0.82, 0.81, 0.79))
INKS: tuple[Reflectance, ...] = (
    (0.45, 0.02, 0.02),
    (0.02, 0.09, 0.30),
    (0.03, 0.20, 0.06),
    (0.70, 0.30, 0.02),
    (0.75, 0.52, 0.03),
    (0.20, 0.03, 0.17),
    (0.02, 0.22, 0.25),
    (0.03, 0.03, 0.035),
    (0.40, 0.20, 0.10),
    (0.55, 0.12, 0.20),
)
BLACK_INK: Reflectance = (0.02, 0.02, 0.022)


def surface(
    rng: np.random.Generator,
    name: str,
    pattern: SurfacePattern,
    colours: Sequence[Reflectance],
    extent: tuple[float, float],
    roughness: tuple[float, float],
    *,
    metallic: float = 0.0,
    size: tuple[int, int] = (SIDE, SIDE),
    wear: float = 0.0,
    layout: tuple[float, ...] = (),
    atlas: bool = False,
) -> OpaqueMaterial:
    """Return a material of a pattern.

    Parameters
    ----------
    rng : numpy.random.Generator
        Draws the seed and the roughness.
    name : str
        Of the material.
    pattern : str
        Its pattern.
    colours : sequence of (r, g, b)
        As the pattern takes them.
    extent : (float, float)
        What one repeat shows [m].
    roughness : (float, float)
        Range of the principled roughness.
    metallic, size, wear, layout
        As in `OpaqueMaterial` and `SurfaceTexture`.
    atlas : bool
        Whether the mesh's texture coordinates run from 0 to 1 over the picture, instead of in metres.
    """
    texture = SurfaceTexture(
        pattern=pattern,
        colours=tuple(tuple(float(value) for value in colour) for colour in colours),  # pyright: ignore[reportArgumentType]
        seed=int(rng.integers(SEED_END)),
        extent=extent,
        size=size,
        wear=wear,
        layout=layout,
    )
    return OpaqueMaterial(
        name=name,
        base_colour=texture,
        repeats=1.0 if atlas else 1.0 / extent[0],
        repeats_v=None if atlas or extent[0] == extent[1] else 1.0 / extent[1],
        roughness=float(rng.uniform(*roughness)),
        metallic=metallic,
    )


def plain(rng: np.random.Generator, name: str, colour: Reflectance, roughness: tuple[float, float]) -> OpaqueMaterial:
    """Return a material of one colour without relief, for small parts."""
    texture = UniformTexture(colour=tuple(float(value) for value in colour))  # pyright: ignore[reportArgumentType]
    return OpaqueMaterial(name=name, base_colour=texture, roughness=float(rng.uniform(*roughness)))


def wooden(
    rng: np.random.Generator, extent: tuple[float, float], wear: float, pattern: SurfacePattern = "solid wood"
) -> OpaqueMaterial:
    """Draw a wood, waxed or lacquered, with its grain along u."""
    kind = tuple(WOODS)[rng.integers(len(WOODS))]
    size = (256, 256)
    return surface(rng, kind, pattern, specimen(rng, WOODS[kind]), extent, (0.3, 0.6), size=size, wear=wear)


def metal(rng: np.random.Generator, wear: float, kind: str = "steel", brushed: float = 0.5) -> OpaqueMaterial:
    """Draw a metal: brushed with a probability, otherwise polished."""
    lines = rng.random() < brushed
    name, roughness = (f"brushed {kind}", (0.26, 0.42)) if lines else (f"polished {kind}", (0.10, 0.22))
    pattern = "brushed metal" if lines else "polished metal"
    return surface(rng, name, pattern, [METALS[kind]], (0.12, 0.12), roughness, metallic=1.0, wear=wear)


def plastic(rng: np.random.Generator, wear: float, colour: Reflectance | None = None) -> OpaqueMaterial:
    """Draw a moulded plastic, matt to glossy."""
    return surface(
        rng, "plastic", "lacquer", [colour or paint_colour(rng)], (0.1, 0.1), (0.18, 0.55), size=(128, 128), wear=wear
    )


def ceramic(rng: np.random.Generator, wear: float, extent: tuple[float, float], bands: int = 0) -> OpaqueMaterial:
    """Draw glazed ceramic: mostly white or cream, with painted bands near the upper edge of the picture."""
    if rng.random() < 0.6:
        ground = dielectric(np.array((0.72, 0.70, 0.66)) * rng.uniform(0.85, 1.1, 1) * (1, 1, rng.uniform(0.85, 1.02)))
    else:
        ground = paint_colour(rng)
    colours = [ground, *(INKS[rng.integers(len(INKS))] for _ in range(bands))]
    pattern = "banded glaze" if bands else "glaze"
    size = (2 * SIDE, SIDE)
    return surface(rng, "glazed ceramic", pattern, colours, extent, (0.06, 0.2), size=size, wear=0.5 * wear)


def print_colours(rng: np.random.Generator) -> tuple[Reflectance, ...]:
    """Draw the colours of a print: ground, two inks, and one for letters that reads on the ground."""
    inks = [INKS[index] for index in rng.permutation(len(INKS))[:3]]
    if rng.random() < 0.5:
        ground = dielectric(np.array(PAPERS[rng.integers(len(PAPERS))]) * rng.uniform(0.9, 1.05))
        return ground, inks[0], inks[1], BLACK_INK if rng.random() < 0.5 else inks[0]
    paper = PAPERS[rng.integers(len(PAPERS))]
    return inks[0], paper, inks[1], paper
