"""Convex parts of bodies of any shape, by approximate convex decomposition; remembered by the content of the mesh.

Wei et al. 2022, "Approximate Convex Decomposition for 3D Meshes with Collision-Aware Concavity and Tree Search" (ACM
TOG 41(4)), by its authors' library. Its seed is fixed, and its result does not depend on the number of threads. It
takes seconds, so results are kept in the user's cache folder; where that cannot be written they are found again.
"""

from __future__ import annotations

import hashlib
import json
from functools import lru_cache
from importlib import metadata
from pathlib import Path

import numpy as np

from ...core.atomic_io import write_atomically
from ...core.cache_folder import cache_folder

#: Concavity at which a part is convex enough, of the body's size [1]; resolution of the sampling of surfaces, nodes and
#: iterations of the search for cuts, and resolution of the closed surface that stands for an open one [1]: below the
#: library's defaults, for the sake of time. Ten sample files take 1 to 18 s and give 5 to 38 parts.
THRESHOLD, RESOLUTION, NODES, ITERATIONS, PREPARATION = 0.05, 1000, 10, 60, 30
#: Most corners of a part [1]: what a part of some centimetres needs to be off by less than the concavity.
MOST_CORNERS = 64
_SEED = 0


def convex_parts(points: np.ndarray, faces: np.ndarray) -> list[np.ndarray]:
    """Return the corners (n, 3) of convex bodies that together are about a body [m].

    Parameters
    ----------
    points : (n, 3) float
        Vertices, each place once [m].
    faces : (m, 3) int
        Triangles; the surface may be open.
    """
    points, faces = np.ascontiguousarray(points, np.float64), np.ascontiguousarray(faces, np.int32)
    digest = hashlib.sha256(repr((points.shape, faces.shape, _version(), _options())).encode())
    digest.update(points.tobytes() + faces.tobytes())
    key = digest.hexdigest()
    known = _read(key)
    if known is None:
        known = _decomposed(points, faces)
        _write(key, known)
    return known


def _decomposed(points: np.ndarray, faces: np.ndarray) -> list[np.ndarray]:
    import coacd  # here, as most scenes have no such body

    coacd.set_log_level("off")
    parts = coacd.run_coacd(coacd.Mesh(points, faces), **_options())
    return [np.asarray(corners, np.float64) for corners, _ in parts]


def _options() -> dict[str, float]:
    return {
        "threshold": THRESHOLD,
        "resolution": RESOLUTION,
        "mcts_nodes": NODES,
        "mcts_iterations": ITERATIONS,
        "preprocess_resolution": PREPARATION,
        "decimate": True,
        "max_ch_vertex": MOST_CORNERS,
        "seed": _SEED,
    }


@lru_cache(maxsize=1)
def _version() -> str:
    return metadata.version("coacd")


def _read(key: str) -> list[np.ndarray] | None:
    try:
        head, _, data = _file(key).read_bytes().partition(b"\n")
        counts = [int(count) for count in json.loads(head)]
        corners = np.frombuffer(data, np.float64).reshape(sum(counts), 3)
    except (OSError, ValueError, TypeError, RuntimeError):  # missing, damaged, or no home: found again
        return None
    return np.split(corners, np.cumsum(counts)[:-1])


def _write(key: str, parts: list[np.ndarray]) -> None:
    head = json.dumps([len(part) for part in parts]).encode()
    try:
        path = _file(key)
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, head + b"\n" + np.concatenate(parts).tobytes())
    except (OSError, RuntimeError):  # a folder that cannot be written: found again next time
        return


def _file(key: str) -> Path:
    return cache_folder() / "convex-parts" / f"{key}.parts"
