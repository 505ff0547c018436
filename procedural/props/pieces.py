"""The parts of a mesh file as one mesh, with the faces of each material next to each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...core.errors import InputError
from ...core.mesh import Mesh
from ..description.material import UniformTexture, VertexColours
from ..mesh_files.model import FilePart, Look, Notes
from .normals import creased

#: Fraction of corners whose stored normal may point into their face, as at slivers; above it all normals are computed.
STRAY_NORMALS = 0.01
#: Thickness of a ground over its longest side, and its shorter side over the longest side of what stands on it [1].
_GROUND_THICKNESS, _GROUND_EXTENT = 1e-3, 3.0
#: Distance up to which positions are one, over the longest side [1]: float32 has 6e-8, and transforms lose a few bits.
_SEAM = 2e-6
#: Most pieces of a prop [1]: each is a shape of its own to the renderer. Of a file with more, those of one colour
#: become one piece with colours of its vertices.
MOST_PIECES = 24


@dataclass(frozen=True)
class Piece:
    """Faces that follow each other in a mesh, and what the file says of them."""

    faces: int
    look: Look
    area: float  #: [m^2]


def joined_pieces(path: Path, name: str, parts: Sequence[FilePart]) -> tuple[Mesh, tuple[Piece, ...]]:
    """Return parts, in metres, as one mesh, and its pieces; parts of equal looks are one piece.

    Raises
    ------
    InputError
        Where no face has an area.
    """
    groups: dict[str, list[FilePart]] = {}
    for part in parts:
        groups.setdefault(_key(part), []).append(part)
    shapes = [
        (group[0].look, [shape for part in group if (shape := _shape(part)) is not None]) for group in _few(groups)
    ]
    shapes = [(look, some) for look, some in shapes if some]
    if not shapes:
        raise InputError(path, "a mesh with faces", "only faces without area")
    every = [shape for _, some in shapes for shape in some]
    has_uv, has_colours = any(shape.uv is not None for shape in every), any(s.colours is not None for s in every)
    offsets = np.cumsum([0, *(len(shape.vertices) for shape in every[:-1])])
    mesh = Mesh(
        name,
        np.concatenate([shape.vertices for shape in every]),
        np.concatenate([shape.faces + offset for shape, offset in zip(every, offsets, strict=True)]),
        np.concatenate([_filled(shape.normals, shape, 3) for shape in every]),
        np.concatenate([_filled(shape.uv, shape, 2) for shape in every]) if has_uv else None,
        np.concatenate([_filled(shape.colours, shape, 3) for shape in every]) if has_colours else None,
    )
    pieces = [Piece(sum(len(s.faces) for s in some), look, sum(_area(s) for s in some)) for look, some in shapes]
    return mesh, tuple(pieces)


def without_ground(notes: Notes, parts: Sequence[FilePart]) -> list[FilePart]:
    """Return parts, z up, without the ground that some exports have below an object: flat, lowest and far larger."""
    boxes = [np.stack([used.min(0), used.max(0)]) for used in (part.vertices[np.unique(part.faces)] for part in parts)]
    sides = [np.ptp(box, axis=0) for box in boxes]
    flat = [side[2] <= _GROUND_THICKNESS * side.max() for side in sides]
    body = [box for box, is_flat in zip(boxes, flat, strict=True) if not is_flat]
    if not body or not any(flat):
        return list(parts)
    low, high = np.min([box[0] for box in body], axis=0), np.max([box[1] for box in body], axis=0)
    extent = float((high - low).max())
    kept = [
        part
        for part, box, side, is_flat in zip(parts, boxes, sides, flat, strict=True)
        if not (is_flat and side[:2].min() >= _GROUND_EXTENT * extent and box[1, 2] <= low[2] + 0.02 * extent)
    ]
    if len(kept) < len(parts):
        notes.say("the ground below it is left out")
    return kept


def sewn(parts: Sequence[FilePart]) -> list[FilePart]:
    """Return the parts with positions that are the same but for rounding made equal, so that seams close.

    Exporters write the two sides of a seam from sine and cosine, or a node's transform rounds them differently.
    """
    vertices = np.concatenate([part.vertices for part in parts])
    reach = _SEAM * float(np.ptp(vertices, axis=0).max())
    import trimesh  # here, as they take half a second to load
    from scipy.spatial import cKDTree

    pairs = cKDTree(vertices).query_pairs(reach, output_type="ndarray")
    label = trimesh.graph.connected_component_labels(pairs, node_count=len(vertices))
    _, first = np.unique(label, return_index=True)
    joined = vertices[first[label]]
    ends = np.cumsum([len(part.vertices) for part in parts])[:-1]
    return [replace(part, vertices=some) for part, some in zip(parts, np.split(joined, ends), strict=True)]


def _key(part: FilePart) -> str:
    look = part.look
    return repr(
        (look.texture, look.roughness, look.metallic, look.maps, look.glass, look.glow, look.texture and look.name)
    )


def _few(groups: dict[str, list[FilePart]]) -> list[list[FilePart]]:
    """Return the groups; of too many, those of one colour as one group with colours of vertices."""
    every = list(groups.values())
    if len(every) <= MOST_PIECES:
        return every
    rest, plain = [], []
    for group in every:
        look = group[0].look
        texture = look.texture
        if isinstance(texture, UniformTexture) and look.glass is None and look.glow is None:
            plain += [replace(part, colours=np.tile(texture.colour, (len(part.vertices), 1))) for part in group]
        else:
            rest.append(group)
    look = replace(plain[0].look, name="several colours", texture=VertexColours()) if plain else Look()
    return [*rest, [replace(part, look=look) for part in plain]] if plain else rest


def _shape(part: FilePart) -> FilePart | None:
    """Return a part at the precision of meshes, with unit normals and faces of three different corners; None: none."""
    # Welding and the search for slivers use the positions as they are stored.
    vertices = part.vertices.astype(np.float32).astype(np.float64)
    corners = vertices[part.faces]
    same = np.any([np.all(corners[:, i] == corners[:, (i + 1) % 3], axis=1) for i in range(3)], axis=0)
    faces = part.faces[~same]
    if not len(faces):
        return None
    uv, colours, normals = part.uv, part.colours, part.normals
    if normals is None or not _agree(vertices, faces, normals):
        extra = None if uv is None and colours is None else _beside(uv, colours, len(vertices))
        vertices, faces, normals, extra = creased(vertices, faces, extra)
        if extra is not None:
            uv = extra[:, :2] if uv is not None else None
            colours = extra[:, 2:] if colours is not None else None
    else:
        used, faces = np.unique(faces, return_inverse=True)
        faces = faces.reshape(-1, 3)
        vertices, normals = vertices[used], normals[used]
        uv, colours = (None if x is None else x[used] for x in (uv, colours))
        normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return replace(part, vertices=vertices, faces=faces, normals=normals, uv=uv, colours=colours)


def _beside(uv: np.ndarray | None, colours: np.ndarray | None, count: int) -> np.ndarray:
    """Return texture coordinates and colours as one table, (count, 5)."""
    blank = np.zeros((count, 2)) if uv is None else uv
    return np.concatenate([blank, np.zeros((count, 3)) if colours is None else colours], axis=1)


def _agree(vertices: np.ndarray, faces: np.ndarray, normals: np.ndarray) -> bool:
    """Return whether stored normals are usable vectors that point out of their faces."""
    if not np.isfinite(normals).all() or np.linalg.norm(normals, axis=1)[np.unique(faces)].min() < 0.5:
        return False
    corners = vertices[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return float(np.mean(np.einsum("fi,fci->fc", cross, normals[faces]) <= 0)) <= STRAY_NORMALS


def _filled(values: np.ndarray | None, shape: FilePart, width: int) -> np.ndarray:
    return np.zeros((len(shape.vertices), width)) if values is None else values


def _area(shape: FilePart) -> float:
    corners = shape.vertices[shape.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return 0.5 * float(np.linalg.norm(cross, axis=1).sum())
