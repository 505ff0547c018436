"""One closed surface of several that overlap, with the normals that each of them has."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce

import numpy as np

from .loft import Solid

#: Details below this are merged [m]: slivers where surfaces meet; a tenth of what a mesh is accurate to.
_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class Bodies:
    """Bodies that make a vessel.

    Parameters
    ----------
    body : Solid
        The vessel's own.
    added : tuple of (Solid, Solid or None)
        What is joined to it, each less a solid that keeps it out of the inside.
    bored : tuple of Solid
        What is taken out of all of them; normals point into it.
    """

    body: Solid
    added: tuple[tuple[Solid, Solid | None], ...] = ()
    bored: tuple[Solid, ...] = ()


def united(bodies: Bodies) -> Solid:
    """Return the union of the bodies less the bores, with their normals, and which faces are around the cavity.

    By `manifold3d`, whose results are closed. The faces of bores count as faces of the cavity.

    Raises
    ------
    ValueError
        Where a body is not closed.
    """
    if not bodies.added and not bodies.bored:
        return bodies.body
    whole = _manifold(bodies.body)
    for solid, kept_out in bodies.added:
        one = _manifold(solid)
        whole = whole + (one if kept_out is None else one - _manifold(kept_out))
    bores = [_manifold(bore, True) for bore in bodies.bored]
    whole = reduce(lambda body, bore: body - bore, bores, whole)
    mesh = whole.set_tolerance(_TOLERANCE).to_mesh64()
    table = np.asarray(mesh.vert_properties, np.float64)
    return _cleaned(table, np.asarray(mesh.tri_verts, np.int64))


def _manifold(solid: Solid, inner: bool = False):
    import manifold3d  # here, as only these vessels need it

    # Which faces are around the cavity goes along as a property of their corners: where both kinds meet, and at
    # creases, there are several corners at one position.
    tag = np.ones(len(solid.faces), bool) if inner else solid.inner
    count = len(solid.vertices)
    used, index = np.unique(solid.faces + np.where(tag, count, 0)[:, None], return_inverse=True)
    source = used % count
    table = np.concatenate([solid.vertices[source], solid.normals[source], (used >= count)[:, None]], axis=1)
    _, first, place = np.unique(table[:, :3], axis=0, return_index=True, return_inverse=True)
    original = first[place.reshape(-1)]
    doubled = np.flatnonzero(original != np.arange(len(original)))
    mesh = manifold3d.Mesh64(
        np.ascontiguousarray(table),
        np.ascontiguousarray(index.reshape(-1, 3), dtype=np.uint64),
        merge_from_vert=doubled.astype(np.uint64),
        merge_to_vert=original[doubled].astype(np.uint64),
    )
    made = manifold3d.Manifold(mesh)
    if made.status() != manifold3d.Error.NoError:
        raise ValueError(f"expected a closed body, found {made.status()}")
    return made


def _cleaned(table: np.ndarray, faces: np.ndarray) -> Solid:
    """Return the solid of a table of corners (position, normal, tag), without faces that vanish in single precision."""
    single = table[:, :3].astype(np.float32)
    corners = single[faces]
    proper = np.all([(corners[:, k] != corners[:, (k + 1) % 3]).any(1) for k in range(3)], axis=0)
    faces = faces[proper]
    length = np.linalg.norm(table[:, 3:6], axis=1, keepdims=True)
    normals = table[:, 3:6] / np.maximum(length, 1e-12)
    return Solid(single.astype(np.float64), normals, faces, table[faces, 6].mean(1) > 0.5)
