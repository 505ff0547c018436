"""Scenes put together by hand, as the renderer sees them."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.procedural.description.surroundings import ConstantEnvironment
from glassware.procedural.optics.medium import Medium
from glassware.procedural.primitives.bodies import ball, prism, slab
from glassware.procedural.primitives.scenes import board, camera, matte, scene
from glassware.render.cache import guiding
from glassware.render.labels.geometry import trace_straight
from glassware.render.pictures.picture import trace_picture
from glassware.render.scene.loaded_scene import load

GLASS = Medium(name="glass", eta=1.5)


@pytest.fixture(scope="module")
def furnace(backend):
    """Clear bodies over a tiny board in light of (1, 2, 0.5) from every direction, and its kernel."""
    bodies = (
        ball(0.05, GLASS, (0.0, 0.0, 0.1), id=2, chord_error=1e-4),
        slab((0.06, 0.06, 0.03), GLASS, (0.12, 0.0, 0.1), id=3),
        prism([(-0.15, 0.08), (-0.09, 0.08), (-0.12, 0.13)], 0.06, GLASS, id=4),
    )
    sky = ConstantEnvironment(radiance=(1.0, 2.0, 0.5), strength=2.0)
    view = camera((0.0, -0.6, 0.1), (0.0, 0.0, 0.1), width=48, height=24, focal=80.0)
    made = scene(bodies, [view], table=board((1e-3, 1e-3, 1e-3), matte()), environment=sky)
    return made, load(made)


def test_clear_bodies_vanish_in_a_constant_environment(furnace):
    made, kernel = furnace
    picture = trace_picture(kernel, made.cameras[0], "left", 3).radiance
    # Every path that ends in the environment brings its radiance; what total reflection keeps longest falls to Russian
    # roulette, whose weights make up for it on the average.
    assert np.median(picture, axis=(0, 1)) == pytest.approx([2.0, 4.0, 1.0], rel=1e-5)
    assert picture.mean((0, 1)) == pytest.approx([2.0, 4.0, 1.0], rel=5e-3)


def test_geometry_shows_each_body_by_its_id(furnace):
    made, kernel = furnace
    geometry, _ = trace_straight(kernel, made.cameras[0], 5)
    assert set(np.unique(geometry.id)) == {0, 2, 3, 4}
    middle = geometry.id[11:13, 23:25]
    assert (middle == 2).all()
    assert geometry.Z[11:13, 23:25] == pytest.approx(0.55, abs=1e-3)


def test_the_guiding_map_takes_a_constant_environment(backend, furnace):
    made, _ = furnace
    cells = np.array(guiding.emission_map(made).cells)
    assert np.isfinite(cells).all()
    # Luminance of (2, 4, 1), the same from every cell well above the horizon.
    assert cells.max() == pytest.approx(0.2126 * 2.0 + 0.7152 * 4.0 + 0.0722 * 1.0, rel=1e-3)
