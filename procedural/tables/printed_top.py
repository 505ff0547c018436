"""The top of a table with prints: the table's own surface and the prints on it, as one picture at a scale in metres."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from ...core.mesh import Mesh
from ..description.material import OpaqueMaterial, SurfaceTexture
from ..description.surroundings import Table, TablePrint
from ..materials.surface_maps import mean_metallic, mean_roughness
from ..patterns.bake import bake_material, bake_surface

#: Side of a texel [m], hardly larger than what a pixel shows of a table: 1.3 mm at 0.4 m with the lens of `train`.
TEXEL = 0.001
#: Most texels of a table [1]: 5 million are 2.2 m x 2.2 m at `TEXEL` and 180 MB for the renderer; larger tables have
#: larger texels.
MOST_TEXELS = 5_000_000
#: Shortest repeat of a table's own pattern [texels]: what repeats faster is shown as its mean.
SHORTEST_REPEAT = 4


@dataclass(frozen=True, eq=False)
class PrintedTop:
    """A table's surface for the renderer."""

    mesh: Mesh  #: the table's, with texture coordinates that run from 0 to 1 over the picture
    colour: np.ndarray  #: (h, w, 3) float32, reflectance, linear Rec.709; the first row is the lower edge
    maps: np.ndarray  #: (h, w, 4) float32: slopes along u and v, roughness, metalness
    texel: tuple[float, float]  #: width and height of a texel [m]
    corner: tuple[float, float]  #: where the lower left corner of the picture is on the top, x and y [m]


def printed_top(table: Table) -> PrintedTop:
    """Return a table's surface with its prints; positions and faces of the mesh are those of the table.

    Parameters
    ----------
    table : Table
        With prints. Its texture coordinates on the top are (x, y) [m].

    Returns
    -------
    PrintedTop
        Colours and maps, one picture over the top and down its sides. The underside has one colour.

    Raises
    ------
    InputError
        If a picture of a texture is missing or unreadable, or its digest is not the recorded one.
    """
    mesh = table.mesh
    assert mesh.uv is not None
    below = np.zeros(len(mesh.vertices), bool) if mesh.normals is None else mesh.normals[:, 2] < -0.99
    shown = mesh.uv[~below].astype(np.float64)
    low, high = shown.min(axis=0), shown.max(axis=0)
    scale = max(TEXEL, float(np.sqrt(np.prod(high - low) / MOST_TEXELS)))
    colour, maps = _surface(table.material)
    period = [1.0 / (table.material.repeats if own is None else own) for own in (None, table.material.repeats_v)]
    if min(period) < SHORTEST_REPEAT * scale:
        colour, maps = (layer.mean(axis=(0, 1), keepdims=True) for layer in (colour, maps))
        period = [100.0 * scale, 100.0 * scale]
    counts = [max(1, round(length / scale)) for length in period]
    texel = np.array(period) / counts
    first = np.floor(low / texel).astype(int) - 1
    last = np.ceil(high / texel).astype(int) + 1
    colour, maps = (_repeated(_resized(layer, counts), first, last) for layer in (colour, maps))
    corner = first * texel
    for item in table.prints:
        _lay(colour, maps, item, texel, corner)
    uv = (mesh.uv - corner) / (texel * (last - first))
    uv[below] = 0.5 / (last - first)
    return PrintedTop(
        replace(mesh, uv=uv.astype(mesh.uv.dtype)),
        colour,
        maps,
        (float(texel[0]), float(texel[1])),
        (float(corner[0]), float(corner[1])),
    )


def _surface(material: OpaqueMaterial) -> tuple[np.ndarray, np.ndarray]:
    """Return a material's colours and its maps, which are even where it has none."""
    colour, maps = bake_material(material)
    if maps is None:
        even = (0.0, 0.0, mean_roughness(material), mean_metallic(material))
        maps = np.array(even, np.float32).reshape(1, 1, 4)
    return colour, maps


def _resized(layer: np.ndarray, counts: list[int]) -> np.ndarray:
    """Return a picture of another size: means of areas where it shrinks, linear between texels where it grows."""
    for axis in range(2):
        size = [layer.shape[1], layer.shape[0]]
        way = cv2.INTER_AREA if counts[axis] < size[axis] else cv2.INTER_LINEAR
        size[axis] = counts[axis]
        layer = cv2.resize(layer, size, interpolation=way).reshape(size[1], size[0], layer.shape[2])
    return layer


def _repeated(layer: np.ndarray, first: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Return a copy of the columns and rows from `first` up to `last` of a picture that repeats in both directions."""
    for axis, (start, end) in zip((1, 0), zip(first, last, strict=True), strict=True):
        count, pieces, place = layer.shape[axis], [], int(start)
        while place < end:
            low = place % count
            high = min(count, low + int(end) - place)
            pieces.append(layer[low:high] if axis == 0 else layer[:, low:high])
            place += high - low
        layer = np.concatenate(pieces, axis)
    return layer


def _lay(colour: np.ndarray, maps: np.ndarray, item: TablePrint, texel: np.ndarray, corner: np.ndarray) -> None:
    """Lay a print on the picture of a top."""
    places = (item.corners - corner) / texel
    low = np.maximum(np.floor(places.min(axis=0)).astype(int) - 1, 0)
    high = np.minimum(np.ceil(places.max(axis=0)).astype(int) + 1, (colour.shape[1], colour.shape[0]))
    if (low >= high).any():
        return
    part = slice(low[1], high[1]), slice(low[0], high[0])
    # From the middles of texels to the frame of the print, whose origin is its lower left corner [m].
    cos, sin = np.cos(item.angle), np.sin(item.angle)
    turn = np.array([[cos, sin], [-sin, cos]])
    start = turn @ (corner + (low + 0.5) * texel - item.centre) + np.array(item.size) / 2
    to_print = np.column_stack([turn * texel, start])
    own, own_maps = _surface(item.material)
    coverage = _within(to_print, high - low, item.size, float(texel.min()))
    texture = item.material.base_colour
    cover = bake_surface(texture).coverage if isinstance(texture, SurfaceTexture) else None
    if cover is not None:
        coverage = coverage * _warped(cover[..., None], to_print, high - low, item.size)[..., 0]
    own, own_maps = (_warped(layer, to_print, high - low, item.size) for layer in (own, own_maps))
    own_maps[..., :2] = own_maps[..., :2] @ turn.astype(np.float32)
    for picture, layer in ((colour, own), (maps, own_maps)):
        picture[part] += coverage[..., None] * (layer - picture[part])


def _within(to_print: np.ndarray, count: np.ndarray, size: tuple[float, float], texel: float) -> np.ndarray:
    """Return how much of each texel lies within a print, (h, w) float32: texels at its edge in part."""
    column, row = np.arange(count[0]), np.arange(count[1])[:, None]
    amount = np.ones((count[1], count[0]))
    for axis in range(2):
        place = to_print[axis, 0] * column + to_print[axis, 1] * row + to_print[axis, 2]
        amount *= np.clip(np.minimum(place, size[axis] - place) / texel + 0.5, 0.0, 1.0)
    return amount.astype(np.float32)


def _warped(layer: np.ndarray, to_print: np.ndarray, count: np.ndarray, size: tuple[float, float]) -> np.ndarray:
    """Return a print's picture at the middles of a top's texels, linear between its own texels."""
    per_metre = np.array([layer.shape[1] / size[0], layer.shape[0] / size[1]])
    matrix = to_print * per_metre[:, None]
    matrix[:, 2] -= 0.5
    found = cv2.warpAffine(
        np.ascontiguousarray(layer),
        matrix,
        (int(count[0]), int(count[1])),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )
    return found.reshape(count[1], count[0], layer.shape[2])
