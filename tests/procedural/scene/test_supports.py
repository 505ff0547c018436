"""Vessels on trays and plates: on the flat part, in nothing, and as often as was asked for."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from glassware.procedural.description.edits import solid_of
from glassware.procedural.description.scene import Scene
from glassware.procedural.placement.overlap import overlap
from glassware.procedural.placement.placement import CONTACT_GAP
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings

#: Most that a foot is above what it stands on [m]: the gap of contacts, and how much a top may rise and still be flat.
ABOVE = CONTACT_GAP + 2e-4 + 1e-6


def drawn(seed: int, kind: str, often: float, count: int = 2) -> Scene:
    return draw_scene(
        SceneSettings.model_validate(
            {
                "vessel_count": (count, count),
                "vessels": {"categories": ["tumbler", "vial", "bowl"], "chord_error": 2e-4, "fill_probability": 0.0},
                "prop_count": (1, 1),
                "props": {"kinds": [kind]},
                "physics": {"piled_probability": 0.0, "lying_probability": 0.0},
                "placement": {"carried_probability": often},
                "cameras": {"views": 1, "width": 64, "height": 48},
                "environment": {"room_share": 0.0, "shipped_share": 0.0},
            }
        ),
        seed,
        0,
    )


def above_carrier(scene: Scene) -> list[float]:
    """How high the foot of each vessel is above the highest place of the carrier under it [m]; inf beside it."""
    (carrier,) = scene.props
    top = solid_of(carrier)
    found = []
    for vessel in scene.vessels:
        if vessel.part_of is not None:
            continue
        points = solid_of(vessel).points
        foot = points[points[:, 2] < points[:, 2].min() + 1e-3, :2]
        # Rays downwards, from places all around the foot and from its middle.
        places = [*foot[:: -(-len(foot) // 24)], foot.mean(0)]
        height = max(_height(top.points[top.faces], place) for place in places)
        found.append(float(points[:, 2].min()) - height)
    return found


def _height(corners: np.ndarray, place: np.ndarray) -> float:
    """The highest place of triangles over a place [m]; -inf beside them."""
    a, b, c = (corners[:, k, :2] - place for k in range(3))
    areas = np.stack([u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0] for u, v in ((b, c), (c, a), (a, b))], axis=1)
    total = areas.sum(1)
    hit = (total > 0.0) & (areas >= 0.0).all(1)
    return float(((areas[hit] * corners[hit, :, 2]).sum(1) / total[hit]).max(initial=-np.inf))


@pytest.mark.parametrize(("kind", "seed"), [("tray", 1), ("plate", 3)])
def test_a_carried_vessel_stands_on_the_flat_part_and_in_nothing(kind, seed):
    scene = drawn(seed, kind, 1.0)
    heights = above_carrier(scene)
    carried = [height for height in heights if np.isfinite(height)]
    assert len(carried) == (2 if kind == "tray" else 1)
    assert all(0.5 * CONTACT_GAP < height < ABOVE for height in carried)
    solids = [solid_of(item) for item in scene.objects]
    assert not any(overlap(*pair) for pair in combinations(solids, 2))


def test_without_it_all_stand_on_the_table():
    scene = drawn(1, "tray", 0.0)
    lowest = [solid_of(vessel).points[:, 2].min() for vessel in scene.vessels]
    np.testing.assert_allclose(lowest, CONTACT_GAP, atol=1e-6)
    assert not np.isfinite(above_carrier(scene)).any()
