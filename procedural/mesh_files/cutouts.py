"""Surfaces that a picture's opacity cuts away: the faces there are taken out of the mesh.

Leaves, fences and cards are flat polygons with holes in their picture. The holes become holes of the mesh, so that
pictures, silhouettes and depth agree.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from ...core.errors import InputError
from ..materials.picture_files import read_opacity
from .model import Cutout, FilePart, Source

#: Most faces to which a part is divided along the outline of its holes [1]; then whole faces go or stay.
MOST_CUT_FACES = 60_000
#: Texels of a face's bounding box up to which it is decided by its middle [1], and most passes of division.
_FINEST, _MOST_PASSES = 1.0, 9


def cutout(
    source: Source, path: Path, threshold: float, what: str, channel: Literal["alpha", "grey"] = "grey"
) -> Cutout | None:
    """Return the cutout of a picture's opacity; None, with a remark, where it cannot be read or cuts nothing."""
    try:
        opacity = read_opacity(path, channel)
    except InputError as error:
        source.notes.say(f"{what}: {error}")
        return None
    return Cutout(opacity, threshold) if opacity is not None and (opacity < threshold).any() else None


def cut(part: FilePart) -> FilePart:
    """Return a part without the surface that its cutout takes away; it may have no faces then."""
    if part.look.cutout is None or part.uv is None:
        return part
    columns = [part.vertices, part.uv, *(x for x in (part.normals, part.colours) if x is not None)]
    values = np.concatenate(columns, axis=1)
    solid = part.look.cutout.opacity >= part.look.cutout.threshold
    faces, kept = part.faces, []
    for number in range(_MOST_PASSES):
        fraction, texels = _solid_fraction(solid, values[faces][..., 3:5])
        last = number == _MOST_PASSES - 1 or 4 * len(faces) + sum(map(len, kept)) > MOST_CUT_FACES
        settled = (fraction == 0.0) | (fraction == 1.0) | (texels <= _FINEST) | last
        kept.append(faces[settled & (fraction >= 0.5)])
        faces = faces[~settled]
        if not len(faces):
            break
        values, faces = _divided(values, faces)
    faces = np.concatenate(kept)
    used, index = np.unique(faces, return_inverse=True)
    return _with_values(part, values[used], index.reshape(-1, 3))


def _solid_fraction(solid: np.ndarray, uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the fraction of solid texels in the bounding box of each face, and the box's longer side [texels]."""
    height, width = solid.shape
    sums = np.zeros((height + 1, width + 1))
    sums[1:, 1:] = np.cumsum(np.cumsum(solid, axis=0, dtype=np.float64), axis=1)
    # The picture repeats: a box is moved by whole pictures so that its lower corner is in the first one.
    base = np.floor(uv.min(1, keepdims=True))
    local = (uv - base) * [width, height]
    low, high = local.min(1), local.max(1)
    across = np.minimum(high - low, [width, height])
    left, right = np.floor(low[:, 0]).astype(int), np.ceil(np.minimum(high[:, 0], width)).astype(int)
    bottom, top = np.floor(low[:, 1]).astype(int), np.ceil(np.minimum(high[:, 1], height)).astype(int)
    left, bottom = np.clip(left, 0, width - 1), np.clip(bottom, 0, height - 1)
    right, top = np.maximum(right, left + 1), np.maximum(top, bottom + 1)
    # v points up, rows down.
    first, last = height - top, height - bottom
    count = sums[last, right] - sums[first, right] - sums[last, left] + sums[first, left]
    return count / ((right - left) * (top - bottom)), across.max(1)


def _divided(values: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices with the middles of all edges, and four faces for each."""
    a, b, c = faces.T
    ends = np.sort(np.concatenate([np.stack([a, b], 1), np.stack([b, c], 1), np.stack([c, a], 1)]), axis=1)
    edges, which = np.unique(ends, axis=0, return_inverse=True)
    ab, bc, ca = (len(values) + which.reshape(3, -1)).tolist()
    middles = 0.5 * (values[edges[:, 0]] + values[edges[:, 1]])
    pieces = [np.stack(corners, 1) for corners in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    return np.concatenate([values, middles]), np.concatenate(pieces)


def _with_values(part: FilePart, values: np.ndarray, faces: np.ndarray) -> FilePart:
    rest = values[:, 5:]
    normals = rest[:, :3] if part.normals is not None else None
    colours = rest[:, -3:] if part.colours is not None else None
    return replace(part, vertices=values[:, :3], faces=faces, uv=values[:, 3:5], normals=normals, colours=colours)
