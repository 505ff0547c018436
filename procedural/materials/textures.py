"""Textures as arrays of linear Rec.709 reflectances: uniform colours, procedural patterns without a seam, pictures."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...core.assets import checked_path
from ..description.material import PictureTexture, ProceduralTexture, Texture, UniformTexture
from .noise import cellular, fractal_gradient_noise, gradient_noise, smoothstep, tile_grid
from .picture_files import read_picture


def bake(texture: Texture) -> np.ndarray:
    """Return a texture as an array that tiles without a seam (pictures tile as well as their file does).

    Row i lies at v = (i + 1/2) / h and column j at u = (j + 1/2) / w: **the first row is the lower edge** of a
    picture, because texture coordinates have v upwards (as in OBJ files).

    Parameters
    ----------
    texture : Texture
        What to bake. The result depends on it and, for a picture, on its file alone.

    Returns
    -------
    (h, w, 3) float32
        Reflectance in [0, 1], linear Rec.709.

    Raises
    ------
    InputError
        Where a picture is missing, unreadable or not the one that was pinned.
    """
    match texture:
        case UniformTexture():
            return np.array(texture.colour, np.float32).reshape(1, 1, 3)
        case ProceduralTexture():
            return _procedural(texture)
        case PictureTexture():
            return np.ascontiguousarray(read_picture(checked_path(texture.asset))[::-1])


def _procedural(texture: ProceduralTexture) -> np.ndarray:
    u, v = tile_grid(texture.resolution)
    rng = np.random.Generator(np.random.PCG64(texture.seed))
    picture = PATTERNS[texture.kind](u, v, np.array(texture.colours), rng)
    return np.clip(picture, 0.0, 1.0).astype(np.float32)


Pattern = Callable[[np.ndarray, np.ndarray, np.ndarray, np.random.Generator], np.ndarray]
"""``pattern(u, v, colours, rng)`` with u, v (n, n) and colours (k, 3) returns (n, n, 3) before clipping."""


def ramp(t: np.ndarray, colours: np.ndarray) -> np.ndarray:
    """Return the colours interpolated along `t` in [0, 1], first to last, in linear light; (..., 3)."""
    knots = np.linspace(0.0, 1.0, len(colours))
    return np.stack([np.interp(t, knots, colours[:, channel]) for channel in range(3)], -1)


def wood(u: np.ndarray, v: np.ndarray, colours: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Plain-sawn boards with the grain along u: growth rings, fibres, pores, and joints if there are several boards."""
    boards = int(rng.choice([1, 4, 5, 6]))
    row = np.floor(v * boards).astype(int) % boards
    x = u + rng.uniform(size=boards)[row]
    y = v + (rng.uniform(size=boards)[row] if boards > 1 else 0.0)
    rings = int(rng.integers(10, 17))
    phase = (y * rings + 2.2 * fractal_gradient_noise(x, y, (1, 3), 3, rng)) % 1.0
    # A ring darkens slowly through the summer and breaks off in winter: late wood is the dark line.
    ring = phase**2 * (1.0 - smoothstep(0.88, 1.0, phase))
    fibres = fractal_gradient_noise(x, y, (3, 80), 2, rng)
    broad = fractal_gradient_noise(x, y, (1, 4), 2, rng)
    pores = smoothstep(0.35, 0.6, gradient_noise(x, y, (10, 150), rng))
    tone = 0.25 + 0.55 * ring + 0.25 * fibres + 0.25 * broad + 0.3 * pores
    tone += rng.uniform(-0.12, 0.12, boards)[row]
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
    # Veins fade in and out along their way.
    veins *= 0.35 + 0.65 * smoothstep(-0.2, 0.4, fractal_gradient_noise(u, v, (2, 2), 2, rng))
    ground = ramp(0.45 * np.clip(clouds, 0.0, 1.0), colours)
    return ground + np.clip(veins, 0.0, 1.0)[..., None] * (colours[-1] - ground)


def checker(u: np.ndarray, v: np.ndarray, colours: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Squares that take turns, each of a slightly different tone."""
    count = 2 * int(rng.integers(2, 5))
    column, row = (u * count).astype(int), (v * count).astype(int)
    tone = (
        1.0
        + rng.uniform(-0.06, 0.06, (count, count))[row, column]
        + 0.05 * fractal_gradient_noise(u, v, (8, 8), 3, rng)
    )
    # Two colours only: three would leave a seam, an even number of squares is no multiple of three.
    return colours[(column + row) % 2] * tone[..., None]


def stripes(u: np.ndarray, v: np.ndarray, colours: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Bands along v of random widths, the colours in turn."""
    count = len(colours) * int(rng.integers(2, 5))
    edges = np.cumsum(rng.uniform(0.4, 1.6, count))
    band = np.searchsorted(edges / edges[-1], u, side="right") % count
    tone = 1.0 + 0.05 * fractal_gradient_noise(u, v, (16, 16), 3, rng)
    return colours[band % len(colours)] * tone[..., None]


def noise(u: np.ndarray, v: np.ndarray, colours: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Blotches at every scale: concrete, cast stone, unevenly painted walls."""
    tone = 0.5 + 0.75 * fractal_gradient_noise(u, v, (4, 4), 6, rng)
    grains = 1.0 + 0.12 * gradient_noise(u, v, (160, 160), rng)
    return ramp(np.clip(tone, 0.0, 1.0), colours) * grains[..., None]


def tiles(u: np.ndarray, v: np.ndarray, colours: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Tiles with grout of the last colour, square or in brick bond, each of its own tone."""
    bond = bool(rng.integers(2))
    across, up = (4, 8) if bond else (6, 6)
    row = (v * up).astype(int)
    x = (u * across + (0.5 * (row % 2) if bond else 0.0)) % across
    column = x.astype(int)
    # Distance from the nearest edge of the tile, in tile widths of the whole picture.
    edge = np.minimum(0.5 - np.abs(x % 1.0 - 0.5), (0.5 - np.abs(v * up % 1.0 - 0.5)) * across / up) / across
    choice = rng.integers(0, max(1, len(colours) - 1), (up, across))[row, column]
    tone = 1.0 + rng.uniform(-0.1, 0.1, (up, across))[row, column] + 0.08 * fractal_gradient_noise(u, v, (6, 6), 4, rng)
    grout = 1.0 - smoothstep(0.004, 0.007, edge)
    bevel = 0.8 + 0.2 * smoothstep(0.007, 0.016, edge)
    surface = colours[choice] * (tone * bevel)[..., None]
    joints = colours[-1] * (1.0 + 0.15 * gradient_noise(u, v, (128, 128), rng))[..., None]
    return surface + grout[..., None] * (joints - surface)


def terrazzo(u: np.ndarray, v: np.ndarray, colours: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Stone chips of the later colours in a ground of the first."""
    colour = colours[0] * (1.0 + 0.08 * fractal_gradient_noise(u, v, (16, 16), 4, rng))[..., None]
    for count, gap, share in ((1200, 0.006, 0.5), (140, 0.014, 0.55)):
        index, edge = cellular(u, v, rng.uniform(size=(count, 2)))
        present = rng.uniform(size=count)[index] < share
        chip = colours[1 + rng.integers(0, len(colours) - 1, count)] * rng.uniform(0.75, 1.2, (count, 1))
        cover = smoothstep(gap, gap + 0.003, edge) * present
        colour = colour + cover[..., None] * (chip[index] - colour)
    return colour


def fabric(u: np.ndarray, v: np.ndarray, colours: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Plain weave: warp of the first colours in bands, weft of the last, threads of uneven tone."""
    # Eight pixels a thread resolve its roundness; an even number keeps the weave periodic.
    threads = max(4, u.shape[1] // 16 * 2)
    column, row = (u * threads).astype(int), (v * threads).astype(int)
    across, along = np.cos(np.pi * (u * threads % 1.0 - 0.5)), np.cos(np.pi * (v * threads % 1.0 - 0.5))
    warp_on_top = (column + row) % 2 == 0
    round_thread = np.where(warp_on_top, across * (0.6 + 0.4 * along), along * (0.6 + 0.4 * across))
    band = (column * 4 // threads) % max(1, len(colours) - 1)
    tones = rng.uniform(0.85, 1.1, (2, threads))
    thread = np.where(
        warp_on_top[..., None], colours[band] * tones[0][column][..., None], colours[-1] * tones[1][row][..., None]
    )
    slub = 1.0 + 0.1 * fractal_gradient_noise(u, v, (8, 8), 4, rng)
    return thread * ((0.45 + 0.6 * round_thread) * slub)[..., None]


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
