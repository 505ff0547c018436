"""Layers: every surface along straight rays, in order, against the stored meshes and against each other."""

from __future__ import annotations

import numpy as np

from ...procedural.description.material_list import materials_of, turbid_media
from ...procedural.description.scene import Scene
from ...render.frame import Geometry, Layers
from .fault import Fault, at_pixels
from .surfaces import DEPTH, RELATIVE
from .triangles import OPAQUE, OUTSIDE, WET_WALL, Triangles
from .truth import Truth, enters, facing_normals

#: Half floats keep 11 bits of a normal's component. Rays that graze a curved wall meet it up to some 0.1 mm aside [1].
HALF_NORMAL = 0.02
#: Fraction of the rays through a vessel that may lack one of two surfaces within some micrometres, with a wide margin:
#: 1 in a million was measured (docs/format.md). One ray of a small picture is more than that: where a liquid touches
#: the wall, two surfaces are too close over some micrometres, so of the rays that meet a liquid a few may lack one.
_MISSED, _MISSED_AT_LIQUIDS = 1e-3, 2


def layer_contradictions(layers: Layers, geometry: Geometry, file: str) -> list[Fault]:
    """Check that layers are in order and without gaps, and that the first is the first surface."""
    found: list[Fault] = []
    for number in range(len(layers.Z)):
        Z, there = layers.Z[number], np.isfinite(layers.Z[number])
        where = f"layers {number}"
        found += at_pixels(where, file, there != (number < layers.count), "as many layers as count says", Z)
        if number:
            before = layers.Z[number - 1]
            found += at_pixels(where, file, there & (before * (1.0 - RELATIVE) > Z), before, Z)
    if len(layers.Z):
        # Two walks along one ray round alike.
        wrong = np.isfinite(geometry.Z) & (layers.Z[0] != geometry.Z)
        found += at_pixels("layers 0", file, wrong, geometry.Z, layers.Z[0])
        found += at_pixels("layers 0", file, layers.id[0] != geometry.id, geometry.id, layers.id[0])
    elif np.isfinite(geometry.Z).any():
        found.append(Fault("layers", file, "the whole view", "layers", "none"))
    return found


def alternation_faults(scene: Scene, layers: Layers, file: str) -> list[Fault]:
    """Check that a ray enters a body before it leaves it, and that both happen equally often where all is recorded.

    The glass of a vessel is closed by its outside and its wet wall.
    """
    found: list[Fault] = []
    whole, known = layers.count <= len(layers.Z), materials_of(scene)
    turbid = turbid_media(scene)
    walls = (layers.part == OUTSIDE) | (layers.part == WET_WALL)
    for body in scene.vessels:
        own = (layers.id == body.id) & walls & np.isfinite(layers.Z)
        seen = own.any(axis=0)  # a tenth of the picture
        own, entering, part, material = (x[:, seen] for x in (own, layers.entering, layers.part, layers.material))
        # The wall that a turbid liquid wets faces the glass, not the liquid.
        beside = np.where(entering, np.isin(material, turbid), material == known.index(body.glass))
        inwards = entering ^ ((part == WET_WALL) & beside)
        steps = np.where(own, np.where(inwards, 1, -1), 0)
        inside = np.cumsum(steps, axis=0)
        balance = steps.sum(axis=0)
        wrong = (inside < 0).any(axis=0) | (inside > 1).any(axis=0) | (whole[seen] & (balance != 0))
        # A liquid's surface and the wall beside it may follow each other too closely for both to be recorded.
        at_liquid = wrong & ((layers.id[:, seen] == body.id) & (part >= WET_WALL)).any(axis=0)
        missed = min(int(at_liquid.sum()), _MISSED_AT_LIQUIDS)
        if wrong.sum() > max(_MISSED * len(wrong), missed):
            broken, sums = np.zeros(seen.shape, bool), np.zeros(seen.shape, int)
            broken[seen], sums[seen] = wrong, balance
            text = f"entering and leaving object {body.id} in turn"
            found += at_pixels("layers entering", file, broken, text, sums)
    return found


def layer_faults(truth: Truth, triangles: Triangles, scene: Scene, layers: Layers, file: str) -> list[Fault]:
    """Compare every layer with the meshes."""
    sure = ~truth.doubtful & ~truth.crowded
    found = at_pixels("layers count", file, (truth.count != layers.count) & sure, truth.count, layers.count)
    if found:
        return found
    hits, kinds = truth.hits, triangles.kind[truth.hits.triangle]
    entering, normals = enters(truth, triangles), facing_normals(truth, triangles)
    materials = _materials(triangles, scene, hits.triangle, entering)
    for number in range(len(layers.Z)):
        chosen = np.flatnonzero(truth.place == number)
        which = np.full(truth.shape, -1)
        which.ravel()[hits.ray[chosen]] = chosen
        there = sure & (which >= 0)
        # Each surface that the renderer's ray leaves moves it by as much again as the slack is for.
        slack = 2.0 * (1 + number) * truth.of_hits(which, hits.slack, 0.0) + 2.0 * DEPTH
        depth = truth.of_hits(which, hits.Z, np.inf)
        apart = ~(np.abs(np.where(there, layers.Z[number] - np.where(there, depth, 0.0), 0.0)) <= slack)
        found += at_pixels(f"layers {number} Z", file, there & apart, depth, layers.Z[number])
        for name, values, stored in (
            ("id", triangles.id[hits.triangle], layers.id),
            ("part", kinds, layers.part),
            ("entering", entering, layers.entering),
            ("material", materials, layers.material),
        ):
            expected = truth.of_hits(which, values, 0)
            known = expected >= 0 if name == "material" else np.ones(truth.shape, bool)
            wrong = there & known & (expected != stored[number])
            found += at_pixels(f"layers {number} {name}", file, wrong, expected, stored[number])
        normal = truth.of_hits(which, normals, 0.0)
        away = np.linalg.norm(np.abs(normal) - np.abs(layers.normal[number].astype(np.float64)), axis=-1)
        found += at_pixels(
            f"layers {number} N", file, there & (away > HALF_NORMAL), normal, layers.normal[number].astype(np.float64)
        )
    return found


def _materials(triangles: Triangles, scene: Scene, triangle: np.ndarray, entering: np.ndarray) -> np.ndarray:
    """Return the number of the medium behind each hit in the list of materials; -1 for opaque solids."""
    known = materials_of(scene)
    numbers = np.array([known.index(medium) for medium in triangles.media] or [0])
    sides = triangles.medium[triangle]
    behind = np.where(entering, sides[:, 1], sides[:, 0])
    return np.where(triangles.kind[triangle] == OPAQUE, -1, numbers[behind])
