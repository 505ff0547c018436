"""Surfaces as arrays for the renderer: the pattern's colour, roughness and slopes, baked once and remembered."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ..description.material import OpaqueMaterial, SurfaceTexture
from ..materials.surface_maps import STEEPEST, bake_maps
from ..materials.textures import bake
from . import cloth, markers, marks, mats, paper_prints, plain, prints, skins, stone, wood
from .grid import Grid, Layers
from .wear import worn

Pattern = Callable[[Grid, np.ndarray], Layers]
"""``pattern(grid, colours)`` with colours (k, 3) returns the layers, colours not yet clipped."""

#: All patterns by their names in `SurfaceTexture`.
PATTERNS: dict[str, Pattern] = {
    "planks": wood.planks,
    "staves": wood.staves,
    "solid wood": wood.solid_wood,
    "granite": stone.granite,
    "marble": stone.marble,
    "concrete": stone.concrete,
    "terrazzo": stone.terrazzo,
    "tiles": stone.tiles,
    "cloth": cloth.plain_weave,
    "checked cloth": cloth.checked,
    "striped cloth": cloth.striped,
    "brushed metal": plain.brushed,
    "polished metal": plain.polished_metal,
    "laminate": plain.laminate,
    "lacquer": plain.lacquer,
    "glaze": plain.glaze,
    "banded glaze": plain.banded,
    "paper": plain.paper,
    "page edges": plain.page_edges,
    "foam": plain.foam,
    "fleece": plain.fleece,
    "chequer": plain.chequer,
    "carton": prints.carton,
    "label": prints.label,
    "cover": prints.cover,
    "screen": prints.screen,
    "citrus skin": skins.citrus,
    "apple skin": skins.apple,
    "banana skin": skins.banana,
    "printed sheet": paper_prints.printed_sheet,
    "newspaper": paper_prints.newspaper,
    "card": paper_prints.card,
    "marker": markers.marker,
    "marker board": markers.marker_board,
    "cutting mat": mats.cutting_mat,
    "place mat": mats.place_mat,
    "ribbed rubber": mats.ribbed_rubber,
    "sticker": marks.sticker,
    "tape": marks.tape,
    "stain": marks.stain,
}
#: Patterns of what shows no scratches: soft, or harder than steel as glaze is.
SOFT = {name for name in PATTERNS if "cloth" in name or "skin" in name} | {
    "foam",
    "fleece",
    "paper",
    "page edges",
    "glaze",
    "banded glaze",
}
#: Surfaces that are remembered [1]: those of a scene. One of 512 x 512 texels has 7 MB with its maps.
_REMEMBERED = 40


def bake_material(material: OpaqueMaterial) -> tuple[np.ndarray, np.ndarray | None]:
    """Return what a material's texture and maps say, whatever kind they are of.

    Parameters
    ----------
    material : OpaqueMaterial
        Any but one with the colours of vertices.

    Returns
    -------
    (h, w, 3) float32, (h, w, 4) float32 or None
        Reflectance as `textures.bake` returns it, and maps as `surface_maps.bake_maps` does; None without maps.

    Raises
    ------
    InputError
        If a picture is missing or unreadable, or its digest is not the recorded one.
    """
    texture = material.base_colour
    if not isinstance(texture, SurfaceTexture):
        return bake(texture), bake_maps(material) if material.is_mapped else None
    layers = bake_surface(texture)
    if not texture.relief:
        return layers.colour, None
    roughness = np.clip(material.roughness * layers.roughness, 0.0, 1.0)
    metallic = np.full_like(roughness, material.metallic)
    slopes = _slopes(layers.height, (texture.extent[0] / texture.size[0], texture.extent[1] / texture.size[1]))
    return layers.colour, np.ascontiguousarray(np.dstack([slopes, roughness, metallic]), np.float32)


def bake_surface(texture: SurfaceTexture) -> Layers:
    """Return the layers of a surface; they depend on the texture alone, and are read-only."""
    return _baked(texture)  # pyright: ignore[reportArgumentType]  # frozen models are hashable at run time


@lru_cache(maxsize=_REMEMBERED)
def _baked(texture: SurfaceTexture) -> Layers:
    rng = np.random.Generator(np.random.PCG64(texture.seed))
    grid = Grid(*texture.extent, *texture.size, rng, texture.wear, texture.layout)
    layers = PATTERNS[texture.pattern](grid, np.array(texture.colours, np.float32))
    layers = worn(grid, layers, scratchable=texture.pattern not in SOFT)
    layers = replace(layers, colour=np.clip(layers.colour, 0.0, 1.0))
    for array in (layers.colour, layers.roughness, layers.height, layers.coverage):
        if array is not None:
            array.setflags(write=False)
    return layers


def _slopes(height: np.ndarray, texel: tuple[float, float]) -> np.ndarray:
    """Return the slopes of a relief [m] along x and y, (h, w, 2) float32; it repeats at its edges."""
    along_x = (np.roll(height, -1, axis=1) - np.roll(height, 1, axis=1)) / np.float32(2.0 * texel[0])
    along_y = (np.roll(height, -1, axis=0) - np.roll(height, 1, axis=0)) / np.float32(2.0 * texel[1])
    return np.clip(np.dstack([along_x, along_y]), -STEEPEST, STEEPEST)
