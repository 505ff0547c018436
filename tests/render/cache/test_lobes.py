"""The material in closed form is Mitsuba's `principled`, and its diffuse part follows from moments of the light."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.render.cache.irradiance_cache import Moments, diffuse
from glassware.render.cache.lobes import OpaqueParameters, eval_glossy, sample_glossy, schlick

#: Directions tried.
COUNT = 20_000
#: Float32 with a few hundred operations; the lobes of nearly smooth surfaces have steep flanks.
RELATIVE = 2e-4
MATERIALS = [
    pytest.param(0.5, 0.0, (0.8, 0.3, 0.1), id="half rough"),
    pytest.param(0.1, 0.0, (0.8, 0.3, 0.1), id="shiny"),
    pytest.param(0.3, 1.0, (0.9, 0.6, 0.3), id="metal"),
    pytest.param(1.0, 0.0, (0.5, 0.5, 0.5), id="rough"),
    pytest.param(0.2, 0.4, (0.5, 0.4, 0.3), id="half metal"),
]


@pytest.fixture(scope="module")
def directions() -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(1)
    pair = rng.normal(size=(2, 3, COUNT)).astype(np.float32)
    pair /= np.linalg.norm(pair, axis=1, keepdims=True)
    pair[:, 2] = np.abs(pair[:, 2])
    return pair[0], pair[1]


@pytest.mark.parametrize(("roughness", "metallic", "colour"), MATERIALS)
def test_diffuse_and_glossy_part_add_up_to_the_material(backend, directions, roughness, metallic, colour) -> None:
    import drjit as dr
    import mitsuba as mi

    wi, wo = (mi.Vector3f(x) for x in directions)
    bsdf = mi.load_dict(
        {
            "type": "principled",
            "base_color": {"type": "rgb", "value": list(colour)},
            "roughness": roughness,
            "metallic": {"type": "uniform", "value": metallic},
        }
    )
    si = dr.zeros(mi.SurfaceInteraction3f, COUNT)
    si.wi, si.n = wi, mi.Normal3f(0.0, 0.0, 1.0)
    si.sh_frame = mi.Frame3f(si.n)
    expected = np.array(bsdf.eval(mi.BSDFContext(), si, wo))

    gloss = OpaqueParameters(mi.Color3f(*colour), mi.Float(roughness), mi.Float(metallic))
    # Light of irradiance cos(wo) from wo alone: its moments are known, and its mean directions are exact.
    E = mi.Color3f(wo.z)
    whole = eval_glossy(gloss, wi, wo)[0] + diffuse(gloss, wi, wi, Moments(E, schlick(wo.z) * E, wo, wo))
    np.testing.assert_allclose(np.array(whole), expected, rtol=RELATIVE, atol=1e-6)


def test_glossy_directions_come_with_the_density_that_is_said(backend) -> None:
    import drjit as dr
    import mitsuba as mi

    count, gloss = 1 << 20, OpaqueParameters(mi.Color3f(0.5), mi.Float(0.7), mi.Float(0.0))
    wi = dr.normalize(mi.Vector3f(0.6, 0.1, 0.5))
    wi = mi.Vector3f(*(mi.Float(np.full(count, float(x[0]), np.float32)) for x in wi))
    rng = np.random.default_rng(2)
    drawn = np.array(sample_glossy(gloss, wi, mi.Point2f(rng.random((2, count), np.float32))))
    uniform = rng.normal(size=(3, count)).astype(np.float32)
    uniform /= np.linalg.norm(uniform, axis=0)
    _, pdf = eval_glossy(gloss, wi, mi.Vector3f(uniform))
    pdf = np.array(pdf, np.float64) * 4.0 * np.pi
    # The share of draws in each octant-like cell of the upper half against the integral of the density there.
    for sign_x in (-1, 1):
        for low, high in ((0.0, 0.4), (0.4, 0.8), (0.8, 1.0)):
            hits, share = ((s[0] * sign_x > 0) & (s[2] > low) & (s[2] <= high) for s in (drawn, uniform))
            values = np.where(share, pdf, 0.0)
            error = np.sqrt((values.var() + hits.var()) / count)
            assert abs(hits.mean() - values.mean()) < 5.0 * error
