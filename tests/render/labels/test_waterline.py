"""Straight rays to the line where a liquid ends at what stands in it."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.dataset.settings.draw import draw
from glassware.procedural.description.bodies import Prop
from glassware.render._mitsuba import mi
from glassware.render.labels.geometry import straight_hits
from glassware.render.labels.refraction import refract
from glassware.render.scene.loaded_scene import load

#: Rays to each vertex of the line, and how far from it [m].
RAYS, NEAREST, FARTHEST = 1000, 1e-7, 1e-4


def _standing(seed: int):
    contents = dict.fromkeys(("layered", "turbid", "ice", "bubbles", "beads"), 0.0) | {"standing": 1.0}
    return draw(
        seed,
        vessels={
            "categories": ["tumbler", "beaker"],
            "fill_probability": 1.0,
            "fill": [0.5, 0.9],
            "contents": contents,
        },
        vessel_count=[1, 1],
        prop_count=[0, 0],
        environment={"room_share": 0.0, "shipped_share": 0.0},
        cameras={"views": 1, "distance": (0.45, 0.5), "elevation": (np.radians(60.0), np.radians(75.0))},
    )


def _waterline(prop: Prop) -> np.ndarray:
    """The vertices that its wet and its dry part share, (n, 3), in the world."""
    wet, dry = np.split(prop.mesh.vertices[prop.mesh.faces], [prop.pieces[0].faces])
    assert prop.pieces[0].surrounding is not None
    shared = {tuple(point) for point in wet.reshape(-1, 3)} & {tuple(point) for point in dry.reshape(-1, 3)}
    return np.array(sorted(shared)) @ prop.world_T_object[:3, :3].T + prop.world_T_object[:3, 3]


@pytest.mark.parametrize(("seed", "category"), [(3, "spoon"), (0, "straw")])
def test_nothing_lies_before_the_first_surface_where_a_liquid_ends(backend, rng, seed, category):
    """A few rays slip through between the liquid and what stands in it; the eye is in air for them as well."""
    scene = _standing(seed)
    (prop,) = scene.props
    assert prop.category == category
    line, eye = _waterline(prop), scene.cameras[0].world_T_camera[:3, 3]
    away = rng.normal(size=(RAYS, 3)) * np.exp(rng.uniform(np.log(NEAREST), np.log(FARTHEST), (RAYS, 1)))
    direction = (line[:, None] + away).reshape(-1, 3) - eye
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    ray = mi.Ray3f(mi.Point3f(*eye.tolist()), mi.Vector3f(*direction.T.astype(np.float32)))
    loaded = load(scene)
    hits = straight_hits(loaded, ray)
    first = np.array(hits.first_id) == prop.id
    assert first.sum() > 10_000
    assert (np.array(hits.transmittance)[:, first] == 1.0).all()
    end = refract(loaded, ray)
    at_once = (np.array(end.bounces) == 0) & (np.array(end.instance) == prop.id)
    assert at_once.sum() > 10_000
    assert (np.array(end.transmittance)[:, at_once] == 1.0).all()
