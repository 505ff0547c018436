"""Textures as arrays of linear Rec.709 reflectances: uniform colours, procedural patterns without a seam, pictures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ...core.assets import checked_path
from ..description.material import (
    PictureTexture,
    ProceduralTexture,
    SurfaceTexture,
    Texture,
    UniformTexture,
    VertexColours,
)
from .noise import cellular, fractal_gradient_noise, gradient_noise, smoothstep, tile_grid
from .picture_files import read_picture

Pattern = Callable[[np.ndarray, np.ndarray, np.ndarray, np.random.Generator], np.ndarray]
"""``pattern(u, v, colours, rng)`` with u, v (n, n) and colours (k, 3) returns (n, n, 3) before clipping."""

# Ranges of the drawn properties of patterns. Counts are per texture tile; ranges of integers exclude their end. Tones
# are factors on a colour or offsets along its ramp [1]. All are chosen by eye to resemble the material, none measured.

#: Boards across a texture tile of wood: a solid panel, or strips of 0.1-0.3 m where the tile is 0.6-1.1 m wide.
BOARDS = (1, 4, 5, 6)
#: Growth rings across a texture tile, and the largest offset of a board's tone.
RINGS, BOARD_TONE = (10, 17), 0.12
#: Half of the number of squares along a side (the number is even, so that the pattern is periodic), and the largest
#: offset of a square's tone.
CHECKER_PAIRS, SQUARE_TONE = (2, 5), 0.06
#: Bands of each colour, and the widths of bands relative to each other.
BANDS_PER_COLOUR, BAND_WIDTH = (2, 5), (0.4, 1.6)
#: Tiles along u and v: in brick bond twice as wide as high, otherwise square.
BRICK_TILES, SQUARE_TILES = (4, 8), (6, 6)
#: Largest offset of a tile's tone.
TILE_TONE = 0.1
#: Range of the tones of single chips in terrazzo: of mixed stone, they differ more than tiles do.
CHIP_TONE = (0.75, 1.2)
#: Range of the tones of single threads of a fabric.
THREAD_TONE = (0.85, 1.1)


#: Patterns that are remembered [1]: those of a scene's table and props. A pattern of 512 x 512 texels has 3 MB.
_REMEMBERED = 8


@dataclass(frozen=True)
class _Chips:
    """One size of the stone chips in terrazzo."""

    count: int  #: Voronoi cells on a texture tile
    gap: float  #: distance from a chip's edge to the edge of its cell [texture tile]
    probability: float  #: that a cell holds a chip


#: Small chips first: large ones lie over them.
CHIPS = (_Chips(1200, 0.006, 0.5), _Chips(140, 0.014, 0.55))


def bake(texture: Texture) -> np.ndarray:
    """Return a texture as an array that tiles without a seam (a picture has a seam unless its file is periodic).

    Row i lies at v = (i + 1/2) / h and column j at u = (j + 1/2) / w: **the first row is the lower edge** of a
    picture, because texture coordinates have v upwards (as in OBJ files).

    Parameters
    ----------
    texture : Texture
        The texture. The result depends only on it and, for a picture, on its file.

    Returns
    -------
    (h, w, 3) float32
        Reflectance in [0, 1], linear Rec.709. That of a pattern is read-only, because the last ones are remembered (a
        scene is often loaded again with another camera or light).

    Raises
    ------
    InputError
        If a picture is missing or unreadable, or its digest is not the recorded one.
    """
    match texture:
        case UniformTexture():
            return np.array(texture.colour, np.float32).reshape(1, 1, 3)
        case ProceduralTexture():
            return _procedural(texture)  # pyright: ignore[reportArgumentType]  # frozen models are hashable at run time
        case PictureTexture():
            pixels = np.ascontiguousarray(read_picture(checked_path(texture.asset))[::-1])
            return pixels if texture.factor == (1.0, 1.0, 1.0) else pixels * np.array(texture.factor, np.float32)
        case SurfaceTexture():
            raise ValueError("expected a texture without relief, found a surface (`patterns.bake.bake_material`)")
        case VertexColours():
            raise ValueError("expected a texture of its own, found the colours of a mesh's vertices")


@lru_cache(maxsize=_REMEMBERED)
def _procedural(texture: ProceduralTexture) -> np.ndarray:
    u, v = tile_grid(texture.resolution)
    rng = np.random.Generator(np.random.PCG64(texture.seed))
    picture = PATTERNS[texture.kind](u, v, np.array(texture.colours), rng)
    pixels = np.clip(picture, 0.0, 1.0).astype(np.float32)
    pixels.setflags(write=False)
    return pixels


def ramp(t: np.ndarray, colours: np.ndarray) -> np.ndarray:
    """Return the colours interpolated along `t` in [0, 1], first to last, in linear light; (..., 3)."""
    knots = np.linspace(0.0, 1.0, len(colours))
    return np.stack([np.interp(t, knots, colours[:, channel]) for channel in range(3)], -1)


def wood(u: np.ndarray, v: np.ndarray, colours: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Plain-sawn boards with the grain along u: growth rings, fibres, pores, and joints if there are several boards."""
    boards = int(rng.choice(BOARDS))
    row = np.floor(v * boards).astype(int) % boards
    x = u + rng.uniform(size=boards)[row]
    y = v + (rng.uniform(size=boards)[row] if boards > 1 else 0.0)
    rings = int(rng.integers(*RINGS))
    phase = (y * rings + 2.2 * fractal_gradient_noise(x, y, (1, 3), 3, rng)) % 1.0
    # A ring darkens slowly through the summer and ends abruptly in winter: late wood is the dark line.
    ring = phase**2 * (1.0 - smoothstep(0.88, 1.0, phase))
    fibres = fractal_gradient_noise(x, y, (3, 80), 2, rng)
    broad = fractal_gradient_noise(x, y, (1, 4), 2, rng)
    pores = smoothstep(0.35, 0.6, gradient_noise(x, y, (10, 150), rng))
    tone = 0.25 + 0.55 * ring + 0.25 * fibres + 0.25 * broad + 0.3 * pores
    tone += rng.uniform(-BOARD_TONE, BOARD_TONE, boards)[row]
    colour = ramp(np.clip(tone, 0.0, 1.0), colours)
    if boards > 1:
        joint = np.abs((v * boards + 0.5) % 1.0 - 0.5) / boards
        # Joints of 2 mm on a tile of about one metre.
        colour = colour * (0.35 + 0.65 * smoothstep(0.0005, 0.0025, joint))[..., None]
    return colour


def marble(u: np.ndarray, v: np.ndarray, colours: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Polished stone: clouds of the first colours, thin veins of the last one along folded noise."""
    x = u + 0.12 * fractal_gradient_noise(u, v, (2, 2), 4, rng)
    y = v + 0.12 * fractal_gradient_noise(u, v, (2, 2), 4, rng)
    clouds = 0.5 + 0.8 * fractal_gradient_noise(x, y, (2, 2), 5, rng)
    thick = np.abs(fractal_gradient_noise(x, y, (1, 2), 3, rng))
    thin = np.abs(fractal_gradient_noise(x, y, (3, 3), 4, rng))
    veins = 0.8 * (1.0 - smoothstep(0.0, 0.05, thick)) + 0.5 * (1.0 - smoothstep(0.0, 0.03, thin))
    # Veins fade in and out along their length.
    veins *= 0.35 + 0.65 * smoothstep(-0.2, 0.4, fractal_gradient_noise(u, v, (2, 2), 2, rng))
    ground = ramp(0.45 * np.clip(clouds, 0.0, 1.0), colours)
    return ground + np.clip(veins, 0.0, 1.0)[..., None] * (colours[-1] - ground)


def checker(u: np.ndarray, v: np.ndarray, colours: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Squares of two colours in turn, each with a slightly different tone."""
    count = 2 * int(rng.integers(*CHECKER_PAIRS))
    column, row = (u * count).astype(int), (v * count).astype(int)
    tone = 1.0 + rng.uniform(-SQUARE_TONE, SQUARE_TONE, (count, count))[row, column]
    tone += 0.05 * fractal_gradient_noise(u, v, (8, 8), 3, rng)
    # Two colours only: three would leave a seam, an even number of squares is no multiple of three.
    return colours[(column + row) % 2] * tone[..., None]


def stripes(u: np.ndarray, v: np.ndarray, colours: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Bands along v of random widths, with the colours in turn."""
    count = len(colours) * int(rng.integers(*BANDS_PER_COLOUR))
    edges = np.cumsum(rng.uniform(*BAND_WIDTH, count))
    band = np.searchsorted(edges / edges[-1], u, side="right") % count
    tone = 1.0 + 0.05 * fractal_gradient_noise(u, v, (16, 16), 3, rng)
    return colours[band % len(colours)] * tone[..., None]


def noise(u: np.ndarray, v: np.ndarray, colours: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Fractal blotches: concrete, cast stone, unevenly painted walls."""
    tone = 0.5 + 0.75 * fractal_gradient_noise(u, v, (4, 4), 6, rng)
    grains = 1.0 + 0.12 * gradient_noise(u, v, (160, 160), rng)
    return ramp(np.clip(tone, 0.0, 1.0), colours) * grains[..., None]


def tiles(u: np.ndarray, v: np.ndarray, colours: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Tiles with grout of the last colour, square or in brick bond, each with a different tone."""
    bond = bool(rng.integers(2))  # both layouts are equally probable
    across, up = BRICK_TILES if bond else SQUARE_TILES
    row = (v * up).astype(int)
    x = (u * across + (0.5 * (row % 2) if bond else 0.0)) % across
    column = x.astype(int)
    # Distance from the nearest edge of the tile, in tile widths of the whole picture.
    edge = np.minimum(0.5 - np.abs(x % 1.0 - 0.5), (0.5 - np.abs(v * up % 1.0 - 0.5)) * across / up) / across
    choice = rng.integers(0, max(1, len(colours) - 1), (up, across))[row, column]
    tone = (
        1.0
        + rng.uniform(-TILE_TONE, TILE_TONE, (up, across))[row, column]
        + 0.08 * fractal_gradient_noise(u, v, (6, 6), 4, rng)
    )
    grout = 1.0 - smoothstep(0.004, 0.007, edge)
    bevel = 0.8 + 0.2 * smoothstep(0.007, 0.016, edge)
    surface = colours[choice] * (tone * bevel)[..., None]
    joints = colours[-1] * (1.0 + 0.15 * gradient_noise(u, v, (128, 128), rng))[..., None]
    return surface + grout[..., None] * (joints - surface)


def terrazzo(u: np.ndarray, v: np.ndarray, colours: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Stone chips of the later colours in a ground of the first."""
    colour = colours[0] * (1.0 + 0.08 * fractal_gradient_noise(u, v, (16, 16), 4, rng))[..., None]
    for chips in CHIPS:
        count = chips.count
        index, edge = cellular(u, v, rng.uniform(size=(count, 2)))
        present = rng.uniform(size=count)[index] < chips.probability
        chip = colours[1 + rng.integers(0, len(colours) - 1, count)] * rng.uniform(*CHIP_TONE, (count, 1))
        cover = smoothstep(chips.gap, chips.gap + 0.003, edge) * present
        colour = colour + cover[..., None] * (chip[index] - colour)
    return colour


def fabric(u: np.ndarray, v: np.ndarray, colours: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Plain weave: warp of the first colours in bands, weft of the last, threads of uneven tone."""
    # Eight pixels per thread resolve its round section; an even number keeps the weave periodic.
    threads = max(4, u.shape[1] // 16 * 2)
    column, row = (u * threads).astype(int), (v * threads).astype(int)
    across, along = np.cos(np.pi * (u * threads % 1.0 - 0.5)), np.cos(np.pi * (v * threads % 1.0 - 0.5))
    warp_on_top = (column + row) % 2 == 0
    section = np.where(warp_on_top, across * (0.6 + 0.4 * along), along * (0.6 + 0.4 * across))
    band = (column * 4 // threads) % max(1, len(colours) - 1)
    tones = rng.uniform(*THREAD_TONE, (2, threads))
    thread = np.where(
        warp_on_top[..., None], colours[band] * tones[0][column][..., None], colours[-1] * tones[1][row][..., None]
    )
    slub = 1.0 + 0.1 * fractal_gradient_noise(u, v, (8, 8), 4, rng)
    return thread * ((0.45 + 0.6 * section) * slub)[..., None]


#: All patterns, by their kind in `ProceduralTexture`.
PATTERNS: dict[str, Pattern] = {
    "wood": wood,
    "marble": marble,
    "checker": checker,
    "stripes": stripes,
    "noise": noise,
    "tiles": tiles,
    "terrazzo": terrazzo,
    "fabric": fabric,
}
