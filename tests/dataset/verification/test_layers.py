"""Rays enter and leave a body in turn; where a liquid touches the wall, one of two surfaces may be missing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from glassware.dataset.reader import Dataset
from glassware.dataset.verification.layers import alternation_faults

#: Places of `layers.exr`'s parts in `render.frame.PARTS`: walls of vessels, and where liquid touches them.
OUTSIDE, WET_WALL = 1, 2


@pytest.fixture(scope="module")
def stored(proven):
    (scene,) = Dataset.open(proven).scenes
    return scene.scene(), scene.views[0].layers()


def without_a_wall(layers, rays):
    """Return layers of which some rays lack the first wall of a vessel."""
    fields = {name: getattr(layers, name).copy() for name in ("Z", "id", "part", "material", "entering", "count")}
    for row, column in rays:
        first = int(np.flatnonzero(np.isin(layers.part[:, row, column], (OUTSIDE, WET_WALL)))[0])
        for name in ("Z", "id", "part", "material", "entering"):
            along = fields[name][:, row, column]
            along[first:-1] = along[first + 1 :]
            along[-1] = np.inf if name == "Z" else 0
        fields["count"][row, column] -= 1
    return replace(layers, **fields)


@pytest.mark.parametrize(("liquid", "rays", "named"), [(True, 2, False), (True, 3, True), (False, 1, True)])
def test_two_rays_that_meet_a_liquid_may_lack_a_surface_and_no_others(stored, liquid, rays, named):
    scene, layers = stored
    walls = np.isin(layers.part, (OUTSIDE, WET_WALL)).any(axis=0)
    chosen = np.argwhere(walls & ((layers.part >= WET_WALL).any(axis=0) == liquid))[:rays]
    assert len(chosen) == rays
    assert alternation_faults(scene, layers, "layers.exr") == []
    faults = alternation_faults(scene, without_a_wall(layers, chosen), "layers.exr")
    assert [fault.check for fault in faults] == ["layers entering"] * named
