"""Several bodies in one file: which way each looks, and one solid of those that overlap."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

#: Faces at an edge whose angles differ by less lie on each other [rad].
_SAME_ANGLE = 1e-4


def bodies_of(faces: np.ndarray) -> np.ndarray:
    """Return the number of the body of each face, (m,): faces that share an edge with no other face are in one."""
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1).astype(np.int64)
    _, edge, count = np.unique(
        ends[:, 0] * (int(faces.max()) + 1) + ends[:, 1], return_inverse=True, return_counts=True
    )
    order = np.argsort(edge.reshape(-1), kind="stable")
    a, b = order[np.repeat(count, count) == 2].reshape(-1, 2).T // 3
    total = len(faces)
    return connected_components(coo_array((np.ones(len(a)), (a, b)), shape=(total, total)), directed=False)[1]


def parted(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices and faces with points of its own for each body, so that bodies that touch are apart.

    Where that leaves edges open, faces at an edge of four and more with a wedge of solid between them are of one body.
    """
    body = bodies_of(faces)
    apart = _with_own_points(vertices, faces, body)
    if _is_closed(apart[1]) or (wedges := _wedges(vertices, faces)) is None:
        return apart
    (a, b), numbers = body[wedges].T, int(body.max()) + 1
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(numbers, numbers))
    joined = _with_own_points(vertices, faces, connected_components(graph, directed=False)[1][body])
    return joined if _is_closed(joined[1]) else apart


def _with_own_points(vertices: np.ndarray, faces: np.ndarray, body: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    count = len(vertices)
    used, index = np.unique(body[:, None] * count + faces, return_inverse=True)
    return vertices[used % count], index.reshape(-1, 3)


def _is_closed(faces: np.ndarray) -> bool:
    """Return whether each edge has two faces."""
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1).astype(np.int64)
    return bool((np.unique(ends[:, 0] * (int(faces.max()) + 1) + ends[:, 1], return_counts=True)[1] == 2).all())


def _wedges(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray | None:
    """Return pairs of faces with solid between them at edges of more than two, (p, 2); None where sides disagree."""
    start, end = faces.reshape(-1).astype(np.int64), np.roll(faces, -1, axis=1).reshape(-1).astype(np.int64)
    third = np.roll(faces, -2, axis=1).reshape(-1)
    low, high = np.minimum(start, end), np.maximum(start, end)
    _, edge, number = np.unique(low * len(vertices) + high, return_inverse=True, return_counts=True)
    corners = np.flatnonzero(number[edge.reshape(-1)] > 2)
    pairs = []
    for group in _groups(corners, edge.reshape(-1)[corners]):
        forward = start[group] == low[group]
        if 2 * int(forward.sum()) != len(group):
            return None
        along = vertices[high[group[0]]] - vertices[low[group[0]]]
        along /= max(float(np.linalg.norm(along)), np.finfo(float).tiny)
        away = vertices[third[group]] - vertices[low[group[0]]]
        away -= (away @ along)[:, None] * along
        first = away[0] / max(float(np.linalg.norm(away[0])), np.finfo(float).tiny)
        angle = np.arctan2(away @ np.cross(along, first), away @ first)
        # Seen along the edge, solid begins at a face that runs against it, and ends at the next one that runs along it.
        turn = (angle[forward][None, :] - angle[~forward][:, None]) % (2.0 * np.pi)
        turn = np.where((turn < _SAME_ANGLE) | (turn > 2.0 * np.pi - _SAME_ANGLE), 2.0 * np.pi, turn)
        chosen = turn.argmin(1)
        if len(set(chosen.tolist())) < len(chosen):
            return None
        pairs.append(np.stack([group[~forward] // 3, group[forward][chosen] // 3], axis=1))
    return np.concatenate(pairs) if pairs else None


def _groups(items: np.ndarray, keys: np.ndarray) -> list[np.ndarray]:
    """Return the items of each key."""
    order = np.argsort(keys, kind="stable")
    return np.split(items[order], np.flatnonzero(np.diff(keys[order])) + 1) if len(items) else []


def oriented(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the faces of closed bodies, turned to look out of the solid: inwards for a bubble in another body."""
    body = bodies_of(faces)
    corners = vertices[faces]
    parts = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    outwards = np.bincount(body, parts) > 0.0
    bubble = np.zeros(len(outwards), dtype=bool)
    if len(outwards) > 1:
        bubble = _depths(corners, body) % 2 == 1
    flip = (outwards == bubble)[body]
    return np.where(flip[:, None], faces[:, ::-1], faces)


def _depths(corners: np.ndarray, body: np.ndarray) -> np.ndarray:
    """Return how many other bodies are around each body: all of its box is within theirs, and a point is inside."""
    count = int(body.max()) + 1
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    for k in range(3):
        np.minimum.at(low, body, corners[:, k])
        np.maximum.at(high, body, corners[:, k])
    depth = np.zeros(count, dtype=np.int64)
    for inner in range(count):
        around = np.flatnonzero(((low <= low[inner]) & (high >= high[inner])).all(1))
        point = corners[body == inner][0].mean(0)
        for outer in around[around != inner]:
            depth[inner] += _crossings_above(corners[body == outer], point) % 2
    return depth


def _crossings_above(corners: np.ndarray, point: np.ndarray) -> int:
    p, q, r = (corners[:, k, :2] - point[:2] for k in range(3))
    areas = np.stack([_cross(q, r), _cross(r, p), _cross(p, q)], axis=1)
    total = areas.sum(1)
    hit = (total != 0.0) & ((areas > 0.0).all(1) | (areas < 0.0).all(1))
    return int(((areas[hit] * corners[hit, :, 2]).sum(1) / total[hit] > point[2]).sum())


def _cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]


def united(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Return the vertices and faces of the union of all bodies less their bubbles; None where there is none.

    By `manifold3d`, whose results are closed whatever the input's rounding.
    """
    import manifold3d

    body = bodies_of(faces)
    corners = vertices[faces]
    volume = np.bincount(body, np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])))
    if len(volume) < 2:
        return None
    made = []
    for number in range(len(volume)):
        some = faces[body == number]
        used, index = np.unique(some if volume[number] > 0.0 else some[:, ::-1], return_inverse=True)
        mesh = manifold3d.Mesh(vertices[used].astype(np.float32), index.reshape(-1, 3).astype(np.uint32))
        one = manifold3d.Manifold(mesh)
        if one.status() != manifold3d.Error.NoError:
            return None
        made.append(one)
    solids = [one for one, size in zip(made, volume, strict=True) if size > 0.0]
    bubbles = [one for one, size in zip(made, volume, strict=True) if size <= 0.0]
    union = manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add)
    if bubbles:
        union = union - manifold3d.Manifold.batch_boolean(bubbles, manifold3d.OpType.Add)
    mesh = union.to_mesh()
    return np.asarray(mesh.vert_properties, np.float64)[:, :3], np.asarray(mesh.tri_verts, np.int64)
