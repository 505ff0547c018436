"""Every interface has its two media on the right sides, by a point-in-solid test that knows nothing of interfaces."""

from __future__ import annotations

import numpy as np
import pytest

import glassware as gw
from glassware.core.mesh import as_trimesh
from glassware.procedural.description.scene import content_solid, glass_solid, liquid_solid
from glassware.procedural.description.standing import standing_in
from glassware.render.pictures.picture import MAX_VIOLATIONS, MediumError, trace_picture
from glassware.render.scene.loaded_scene import load
from glassware.render.scene.rays import leave
from glassware.render.scene.surfaces import registry_id

#: Rays through each vessel, and most surfaces that each is followed through.
RAYS, SURFACES = 150, 24
#: Segments shorter than this are left out: their middle is nearer to a surface than the winding number can tell [m].
SHORTEST = 2e-5
#: Share of segments whose middle may lie within float32 rounding of a seam.
DOUBTFUL = 2e-3


def _rays(rng: np.random.Generator, solid, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Rays from a ball round the solid to points in its bounding box: most cross its wall, many its liquid."""
    low, high = solid.bounds
    origin = rng.normal(size=(count, 3))
    origin = (low + high) / 2 + origin / np.linalg.norm(origin, axis=1, keepdims=True) * np.linalg.norm(high - low)
    target = rng.uniform(low, high, size=(count, 3))
    direction = target - origin
    return origin, direction / np.linalg.norm(direction, axis=1, keepdims=True)


def _segments(kernel, index: int, origin: np.ndarray, direction: np.ndarray):
    """Follow straight rays through the surfaces of one object: (middle, length, medium before, medium after)."""
    import drjit as dr
    import mitsuba as mi

    table = kernel.surfaces
    rows = {name: np.array(getattr(table, name)) for name in ("object", "opaque", "front", "back")}
    ray = mi.Ray3f(mi.Point3f(origin.T.astype(np.float32)), mi.Vector3f(direction.T.astype(np.float32)))
    active = np.ones(len(origin), bool)
    start = origin.copy()
    found = []
    for _ in range(SURFACES):
        si = kernel.mi_scene.ray_intersect(ray)
        valid = np.array(si.is_valid())
        row = np.where(valid, np.array(registry_id(si.shape)), 0)
        # Rays end at anything that is not this vessel.
        active &= valid & (rows["object"][row] == index)
        point, normal = np.array(si.p).T.astype(float), np.array(si.n).T
        from_front = (normal * direction).sum(1) < 0.0
        facing = np.where(from_front, rows["front"][row], rows["back"][row])
        beyond = np.where(from_front, rows["back"][row], rows["front"][row])
        found.append((start.copy(), point, facing, beyond, active.copy()))
        start = point
        ray = leave(si, ray.d, kernel.offset)
        dr.eval(ray)
        if not active.any():
            return found
    return found


def _winding(solid, points: np.ndarray) -> np.ndarray:
    """Generalised winding number (Jacobson et al. 2013, eq. 5): solid angles of all triangles over 4 pi."""
    total = np.empty(len(points))
    for i, point in enumerate(points):
        a, b, c = (solid.triangles[:, k] - point for k in range(3))
        la, lb, lc = (np.sqrt((v * v).sum(1)) for v in (a, b, c))
        triple = (a * np.cross(b, c)).sum(1)
        below = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
        total[i] = 2.0 * np.arctan2(triple, below).sum() / (4.0 * np.pi)
    return total


def _medium_at(vessel, solids, points: np.ndarray) -> np.ndarray:
    found = np.zeros(len(points), int)
    for medium, solid in solids:
        inside = _winding(as_trimesh(solid, vessel.world_T_object), points)
        # Closed surfaces: away from them winding numbers are whole.
        assert np.abs(inside - np.round(inside)).max() < 1e-3
        assert not ((inside > 0.5) & (found > 0)).any()
        found[inside > 0.5] = medium
    return found


@pytest.fixture(scope="module")
def sides(backend, drawn):
    scene = drawn(11, vessel_count=(3, 3), prop_count=(0, 0), vessels={"fill_probability": 1.0, "chord_error": 2e-4})
    return scene, load(scene)


@pytest.mark.parametrize("number", [0, 1, 2])
def test_rays_meet_the_media_that_the_bodies_are_made_of(sides, rng, number):
    scene, kernel = sides
    vessel = scene.vessels[number]
    media = kernel.surfaces.media
    solids = [(media.index(vessel.glass), glass_solid(vessel))]
    pieces = [piece for other in standing_in(scene.objects, vessel) for piece in other.pieces]
    solids += [(media.index(one.medium), liquid_solid(vessel, k, pieces)) for k, one in enumerate(vessel.liquids)]
    solids += [(media.index(one.medium), content_solid(vessel, k)) for k, one in enumerate(vessel.contents)]
    solid = as_trimesh(glass_solid(vessel), vessel.world_T_object)
    origin, direction = _rays(rng, solid, RAYS)
    middles, told = [], []
    for start, end, facing, beyond, active in _segments(kernel, number, origin, direction):
        long = active & (np.linalg.norm(end - start, axis=1) > SHORTEST)
        middles += [((start + end) / 2)[long], (end + SHORTEST * direction)[active]]
        told += [facing[long], beyond[active]]
    points, told = np.concatenate(middles), np.concatenate(told)
    true = _medium_at(vessel, solids, points)
    assert {0, solids[0][0], solids[1][0]} <= set(true[told == true].tolist())
    assert (told != true).mean() <= DOUBTFUL


def test_pictures_of_drawn_scenes_have_no_segment_in_the_wrong_medium_beyond_hairlines(loaded_glasses):
    from dataclasses import replace

    scene = loaded_glasses.description
    # Enough segments (a quarter of a million) for a share this small to be told.
    picture = scene.picture.model_copy(update={"spp": 32})
    kernel = replace(loaded_glasses, description=scene.model_copy(update={"picture": picture}))
    assert trace_picture(kernel, scene.cameras[0], "left", seed=1).violations <= MAX_VIOLATIONS


@pytest.mark.slow
def test_what_stands_in_a_turbid_liquid_is_met_from_inside_it_and_counts_for_nothing(backend):
    """Shading normals lead some rays into the liquid, which is opaque, where they meet a spoon and leave it again."""
    only = {"standing": 1.0, "turbid": 1.0, "layered": 0.0, "ice": 0.0, "beads": 0.0, "bubbles": 0.0}
    scene = gw.draw(
        seed=3,
        vessel_count=[1, 1],
        prop_count=[0, 0],
        vessels={"categories": ["double-walled glass"], "contents": only},
        cameras={"views": 1, "width": 128, "height": 96, "distance": [0.3, 0.35]},
        picture={"light": "path", "spp": 16},
    )
    assert [item.category for item in scene.objects] == ["double-walled glass", "spoon"]
    picture = trace_picture(load(scene), scene.cameras[0], "left", seed=1)
    assert picture.violations < 1e-5  # a tenth of MAX_VIOLATIONS, which they came to


@pytest.mark.parametrize("part", ["outside", "wet_wall", "liquid_surface"])
@pytest.mark.parametrize("fault", ["media exchanged", "missing"])
def test_an_interface_that_is_wrong_is_caught_while_the_picture_is_made(backend, glasses, part, fault):
    def spoiled(vessel):
        kept = [item for item in vessel.interfaces if not (fault == "missing" and item.part == part)]
        turned = [
            item.model_copy(update={"front": item.back, "back": item.front})
            if fault == "media exchanged" and item.part == part
            else item
            for item in kept
        ]
        return vessel.model_copy(update={"interfaces": tuple(turned)})

    first = next(item for item in glasses.vessels if item.liquid)
    kernel = load(glasses.model_copy(update={"vessels": (spoiled(first),), "props": ()}))
    with pytest.raises(MediumError, match="interface is missing, its normal is reversed, or a camera is inside"):
        trace_picture(kernel, glasses.cameras[0], "left", seed=1)
