"""Maps of roughness, metalness and normals: read as Mitsuba reads bitmaps, and turned into shading normals."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glassware.procedural.description.material import OpaqueMaterial, UniformTexture

#: Float32 with some ten operations.
RELATIVE = 2e-5
MAPS = np.random.default_rng(0).uniform(0.05, 1.0, (5, 7, 4)).astype(np.float32)


@pytest.fixture(scope="module")
def points(backend):
    import drjit as dr
    import mitsuba as mi

    si = dr.zeros(mi.SurfaceInteraction3f, 500)
    uv = np.random.default_rng(1).uniform(-2.0, 2.0, (2, 500)).astype(np.float32)
    si.uv = mi.Point2f(*uv)
    si.n = mi.Normal3f(0.0, 0.0, 1.0)
    si.sh_frame = mi.Frame3f(si.n)
    si.dp_du, si.dp_dv = mi.Vector3f(2.0, 0.0, 0.0), mi.Vector3f(0.0, 3.0, 0.0)
    return si


def _values(si, rows: int = 3, row: int = 1):
    import mitsuba as mi

    from glassware.render.scene.surface_maps import surface_maps, values_at

    maps = surface_maps({0: MAPS[:2, :2], row: MAPS}, rows)
    assert maps is not None
    return values_at(maps, si, mi.UInt32(row))


def test_maps_are_read_as_mitsuba_reads_bitmaps(points) -> None:
    import mitsuba as mi

    from glassware.render.scene.bodies import opaque_bsdf

    grey = OpaqueMaterial(name="grey", base_colour=UniformTexture(colour=(0.5, 0.5, 0.5)), roughness=1.0)
    bsdf = mi.load_dict(opaque_bsdf(grey, maps=MAPS))
    values = _values(points)
    for name, found in (("roughness", values.roughness), ("metallic", values.metallic)):
        expected = np.array(bsdf.eval_attribute_1(name, points, True))
        np.testing.assert_allclose(np.array(found), expected, rtol=10 * RELATIVE)
    assert np.array(values.mapped).all()


def test_shapes_without_maps_keep_their_normals(points) -> None:
    import mitsuba as mi

    from glassware.render.scene.surface_maps import above_surface, mapped_normal, surface_maps, values_at

    maps = surface_maps({0: MAPS}, 3)
    assert maps is not None
    values = values_at(maps, points, mi.UInt32(2))
    n, eye = mi.Normal3f(0.0, 0.6, 0.8), mi.Vector3f(0.0, 0.0, 1.0)
    assert not np.array(values.mapped).any()
    found = np.array(mapped_normal(values, points, n, eye))[:, 0]
    np.testing.assert_array_equal(found, np.array([0.0, 0.6, 0.8], np.float32))
    assert np.array(above_surface(values, points, eye, -eye)).all()
    assert surface_maps({}, 3) is None


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("back", [False, True])
def test_a_slope_tilts_the_normal_against_the_axes_of_the_texture(points, mirrored, back) -> None:
    import mitsuba as mi

    from glassware.render.scene.surface_maps import MappedValues, mapped_normal

    si = mi.SurfaceInteraction3f(points)
    si.dp_dv = mi.Vector3f(0.0, -3.0 if mirrored else 3.0, 0.0)
    values = MappedValues(mi.Bool(True), mi.Float(0.5), mi.Float(0.25), mi.Float(1.0), mi.Float(0.0))
    side = -1.0 if back else 1.0
    n = np.array(mapped_normal(values, si, mi.Normal3f(0.0, 0.0, side), mi.Vector3f(0.0, 0.0, side)))[:, 0]
    # The front has the normal of z = 0.5 x + 0.25 y; the back is seen from below.
    expected = side * np.array([-0.5, 0.25 if mirrored else -0.25, 1.0]) / math.sqrt(1.0 + 0.25 + 0.0625)
    np.testing.assert_allclose(n, expected, rtol=RELATIVE)


def test_a_normal_that_turns_away_from_the_eye_is_bent_back(points) -> None:
    import mitsuba as mi

    from glassware.render.scene.surface_maps import MappedValues, mapped_normal

    values = MappedValues(mi.Bool(True), mi.Float(3.0), mi.Float(0.0), mi.Float(1.0), mi.Float(0.0))
    eye = np.array([math.sin(1.3), 0.0, math.cos(1.3)])
    n = np.array(mapped_normal(values, points, mi.Normal3f(0.0, 0.0, 1.0), mi.Vector3f(*eye.tolist())))[:, 0]
    assert n @ eye > 0.0
    assert np.linalg.norm(n) == pytest.approx(1.0, abs=RELATIVE)


def test_the_closed_form_of_the_lobes_is_the_material_with_maps(points) -> None:
    import drjit as dr
    import mitsuba as mi

    from glassware.render.cache.irradiance_cache import Moments, diffuse
    from glassware.render.cache.lobes import OpaqueParameters, eval_glossy, schlick
    from glassware.render.scene.bodies import opaque_bsdf

    rng = np.random.default_rng(2)
    pair = rng.normal(size=(2, 3, 500)).astype(np.float32)
    pair /= np.linalg.norm(pair, axis=1, keepdims=True)
    pair[:, 2] = np.abs(pair[:, 2])
    wi, wo = (mi.Vector3f(x) for x in pair)
    si = mi.SurfaceInteraction3f(points)
    si.wi = wi
    colour = (0.8, 0.3, 0.1)
    material = OpaqueMaterial(name="mapped", base_colour=UniformTexture(colour=colour), roughness=1.0)
    expected = np.array(mi.load_dict(opaque_bsdf(material, maps=MAPS)).eval(mi.BSDFContext(), si, wo))
    values = _values(si)
    gloss = OpaqueParameters(mi.Color3f(*colour), values.roughness, values.metallic)
    E = mi.Color3f(wo.z)
    whole = eval_glossy(gloss, wi, wo)[0] + diffuse(gloss, wi, wi, Moments(E, schlick(wo.z) * E, wo, wo))
    np.testing.assert_allclose(np.array(whole), expected, rtol=2e-3, atol=1e-5)
    dr.eval(whole)


@pytest.mark.parametrize("slope", [0.02, -0.02])
def test_irradiance_of_a_tilted_facet_is_exact_for_one_direction_and_slowly_varying_light(backend, slope) -> None:
    import mitsuba as mi

    from glassware.render.cache.irradiance_cache import tilted_irradiance

    n = np.array([-slope, 0.0, 1.0]) / math.hypot(1.0, slope)
    up, tilted = mi.Normal3f(0.0, 0.0, 1.0), mi.Normal3f(*n.tolist())

    def found(mean: np.ndarray) -> float:
        return float(np.array(tilted_irradiance(mi.Vector3f(*mean.tolist()), up, tilted))[0])

    light = np.array([0.6, 0.0, 0.8])
    assert found(light) == pytest.approx((n @ light) / light[2], rel=1e-6)
    # Radiance 1 + b . w on a fine grid of directions, b small and along x.
    cos, phi = np.meshgrid((np.arange(400) + 0.5) / 400, 2 * np.pi * np.arange(400) / 400)
    sin = np.sqrt(1.0 - cos**2)
    w = np.stack([sin * np.cos(phi), sin * np.sin(phi), cos], axis=-1)
    radiance = 1.0 + 0.1 * w[..., 0]
    E = (radiance * cos).sum()
    mean = (radiance * cos)[..., None] * w
    exact = (radiance * np.maximum(w @ n, 0.0)).sum() / E
    # Of the second order are what is left of the interpolation (|b|^2) and the slope's square.
    assert found(mean.sum((0, 1)) / E) == pytest.approx(exact, abs=3e-4)


def test_a_scene_without_maps_has_none_in_its_table(backend) -> None:
    from glassware.procedural.optics.medium import AIR
    from glassware.render.scene.surfaces import Surface, surface_table

    assert surface_table({1: Surface(0, -1, True, AIR, AIR, 0.0)}, False).maps is None
