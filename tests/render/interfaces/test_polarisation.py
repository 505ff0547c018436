"""Polarised light against the closed forms of optics: single events, piles of plates, white furnaces."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Callable, Iterator
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from glassware.procedural.optics.medium import Medium
from glassware.procedural.surroundings.colour import luminance
from glassware.render.backend.variant import activate
from glassware.render.interfaces.dielectric import InterfaceHit
from glassware.render.interfaces.microsurface import next_height, visible_facet
from glassware.render.interfaces.mueller import as_matrix, identity
from glassware.render.interfaces.polarised import StokesFrame, polarised_facet_event, scatter_polarised, walk_polarised
from glassware.render.pictures.integrator import trace
from glassware.render.pictures.sampler import sobol_sampler
from glassware.render.pictures.stokes import degree_of_polarisation, trace_stokes
from glassware.render.renderer import Renderer
from glassware.render.scene.loaded_scene import load
from glassware.render.scene.spectrum import draw_wavelengths

#: Rounding of float32, and how many follow each other in the few events of a closed form here (amplitudes, frames).
EPS, ROUNDINGS = 2.0**-24, 64
GLASS = 1.5
#: Where the scenes of closed forms are, and the name that they are imported by.
PROOFS, PACKAGE = Path(__file__).resolve().parents[2] / "proofs", "glassware_proofs"


@pytest.fixture(scope="module")
def proofs() -> Callable[[str], ModuleType]:
    """Name -> the module of `tests/proofs`, where bodies of closed forms are."""
    if PACKAGE not in sys.modules:
        spec = ModuleSpec(PACKAGE, None, is_package=True)
        spec.submodule_search_locations = [str(PROOFS)]
        sys.modules[PACKAGE] = importlib.util.module_from_spec(spec)
    return lambda name: importlib.import_module(f"{PACKAGE}.{name}")


@pytest.fixture(
    scope="module",
    params=["llvm_ad_mono_polarized", pytest.param("llvm_ad_spectral_polarized", marks=pytest.mark.slow)],
)
def polarised(request, backend) -> Iterator[str]:
    """A polarised variant, active; afterwards the one that all other tests expect."""
    yield activate(request.param)
    activate(backend)


def amplitudes(theta: np.ndarray, eta: float | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fresnel's sine and tangent laws (Hecht, Optics, eqs. 4.42 and 4.43), complex beyond the critical angle."""
    inside: np.ndarray = np.arcsin(np.sin(theta) / eta + 0j)
    inside = np.where(np.imag(inside) > 0.0, np.conj(inside), inside)  # the wave behind fades with exp(-i omega t)
    return -np.sin(theta - inside) / np.sin(theta + inside), np.tan(theta - inside) / np.tan(theta + inside)


def vector(values):
    """A vector that is not compiled into the kernel: its other values then use the same one."""
    import drjit as dr
    import mitsuba as mi

    return dr.opaque(mi.Vector3f, [float(value) for value in values])


def number(value: float):
    """A number of the same kind."""
    import drjit as dr
    import mitsuba as mi

    return dr.opaque(mi.Float, float(value))


def event(theta: float, eta: float, coin: float, analyser=(1.0, 0.0, 0.0, 0.0), spin: float = 0.0):
    """One event at a smooth interface; its matrix between frames with x across the plane of incidence, and the event.

    `spin` turns the whole arrangement about the vertical, which must not matter.
    """
    import drjit as dr
    import mitsuba as mi

    along = np.array([np.cos(spin), np.sin(spin), 0.0])
    across = vector([-np.sin(spin), np.cos(spin), 0.0])
    wi = vector(np.sin(theta) * along + [0.0, 0.0, np.cos(theta)])
    up = mi.Normal3f(0.0, 0.0, 1.0)
    basis = mi.mueller.stokes_basis
    row = mi.mueller.rotate_stokes_basis(wi, basis(wi), across) @ mi.Matrix4f(1.0)
    turned = mi.Vector4f(*(sum(number(analyser[k]) * row[k, column] for k in range(4)) for column in range(4)))
    made = scatter_polarised(InterfaceHit(wi, up, up, number(eta), number(0.0), number(coin), mi.UInt32(1)), turned)
    light = -made.direction
    matrix = mi.mueller.rotate_mueller_basis(made.weight, light, basis(light), across, wi, basis(wi), across)
    dr.eval(matrix, made)
    return np.array(matrix, np.float64).reshape(4, 4), made


# ---- One event ----


@pytest.mark.parametrize("spin", [0.0, 1.0, 2.5])
@pytest.mark.parametrize("eta", [GLASS, 1.0 / GLASS])
def test_a_mirrored_ray_has_fresnels_matrix(polarised, eta, spin):
    for theta in np.radians([5.0, 30.0, 41.0, 45.0, 60.0, 85.0]):
        matrix, made = event(theta, eta, 0.0, spin=spin)
        s, p = amplitudes(theta, eta)
        total = 0.5 * (abs(s) ** 2 + abs(p) ** 2)
        both = s * np.conj(p) / total
        m, d = 1.0, 0.5 * (abs(s) ** 2 - abs(p) ** 2) / total
        expected = [[m, d, 0, 0], [d, m, 0, 0], [0, 0, both.real, -both.imag], [0, 0, both.imag, both.real]]
        assert not made.transmitted[0]
        # Near the critical angle the phase has a root's slope, which multiplies the rounding of the cosine.
        slope = 1.0 + 1.0 / np.sqrt(abs(np.sin(theta) ** 2 - eta**2)) / np.cos(theta)
        assert np.abs(matrix - expected).max() < ROUNDINGS * EPS * slope / min(1.0, total)


@pytest.mark.parametrize("eta", [GLASS, 1.0 / GLASS])
def test_a_refracted_ray_has_fresnels_matrix(polarised, eta):
    for theta in np.radians([5.0, 30.0, 40.0]):
        matrix, made = event(theta, eta, 1.0 - 2 * EPS, spin=0.7)
        s, p = (1.0 - np.abs(a) ** 2 for a in amplitudes(theta, eta))
        d, c = (s - p) / (s + p), 2.0 * np.sqrt(s * p) / (s + p)
        expected = np.array([[1, d, 0, 0], [d, 1, 0, 0], [0, 0, c, 0], [0, 0, 0, c]]) / eta**2
        assert made.transmitted[0]
        assert np.abs(matrix - expected).max() < ROUNDINGS * EPS


def test_light_mirrored_at_brewsters_angle_is_wholly_polarised_across_the_plane_of_incidence(polarised):
    matrix, _ = event(np.arctan(GLASS), GLASS, 0.0, spin=1.0)
    assert np.allclose(matrix[:, 0], [1.0, 1.0, 0.0, 0.0], atol=ROUNDINGS * EPS)


def test_fresnels_rhomb_makes_circular_light_of_linear_light(polarised):
    """Two total reflections at 54.6 degrees in an index of 1.51 (Born and Wolf 1999, section 1.5.4)."""
    matrix, _ = event(np.radians(54.6), 1.0 / 1.51, 0.0)
    out = matrix @ matrix @ [1.0, 0.0, 1.0, 0.0]
    # 54 deg 37' gives 45 degrees a reflection; 54.6 is right to 0.1 deg, of which the phase follows with a slope < 1.
    assert np.allclose(out, [1.0, 0.0, 0.0, 1.0], atol=2 * np.radians(0.2))
    assert np.linalg.norm(out[1:]) == pytest.approx(1.0, abs=ROUNDINGS * EPS)


def test_outcomes_are_as_likely_as_the_camera_sees_them(polarised):
    """Behind a filter that lets only light pass that swings in the plane of incidence nothing mirrors at Brewster's."""
    theta, crossed = np.arctan(GLASS), (1.0, -1.0, 0.0, 0.0)
    _, made = event(theta, GLASS, 1e-6, crossed)
    assert made.transmitted[0]
    s, _ = amplitudes(np.array(theta), GLASS)
    share = abs(s) ** 2
    for coin, transmitted in ((share - 1e-5, False), (share + 1e-5, True)):
        matrix, made = event(theta, GLASS, float(coin), (1.0, 1.0, 0.0, 0.0))
        assert made.transmitted[0] == transmitted
        scale = GLASS**2 if transmitted else 1.0
        assert scale * (matrix[0, 0] + matrix[1, 0]) == pytest.approx(1.0, abs=ROUNDINGS * EPS)


def test_a_walk_on_a_rough_interface_takes_and_gives_physical_light(polarised):
    """Whatever light arrives, at most wholly polarised light leaves; unpolarised light as bright as it came."""
    import drjit as dr
    import mitsuba as mi

    count = 20_000
    up, wi = mi.Normal3f(0.0, 0.0, 1.0), mi.Vector3f(0.6, 0.48, 0.64)
    coin, seed = dr.zeros(mi.Float, count), mi.sample_tea_32(dr.arange(mi.UInt32, count), mi.UInt32(7))[0]
    made = scatter_polarised(
        InterfaceHit(wi, up, up, mi.Float(GLASS), mi.Float(0.4), coin, seed), mi.Vector4f(1.0, 0.0, 0.0, 0.0)
    )
    matrix = np.array(made.weight * mi.Matrix4f(made.eta_squared), np.float64)
    alive = matrix[0, 0] > 0.0
    assert alive.mean() > 0.999
    matrix = matrix[..., alive]
    assert np.abs(matrix[0, 0] - 1.0).max() < 16 * ROUNDINGS * EPS
    rng = np.random.default_rng(3)
    for _ in range(8):
        state = rng.normal(size=3)
        out = np.einsum("ijn,j->in", matrix, [1.0, *(state / np.linalg.norm(state))])
        assert (np.linalg.norm(out[1:], axis=0) < out[0] + 16 * ROUNDINGS * EPS).all()


def test_an_interface_hardly_rough_polarises_as_a_smooth_one(polarised):
    """The walk takes and gives light in the frames that the smooth event has; the first facet decides."""
    import drjit as dr
    import mitsuba as mi

    theta, alpha, count = np.radians(50.0), 1e-3, 4096
    wi, up = vector([np.sin(theta) * 0.6, np.sin(theta) * 0.8, np.cos(theta)]), mi.Normal3f(0.0, 0.0, 1.0)
    analyser = mi.Vector4f(1.0, 0.3, -0.5, 0.2)
    seeds = mi.sample_tea_32(dr.arange(mi.UInt32, count), mi.UInt32(9))[0]
    rough = scatter_polarised(
        InterfaceHit(wi, up, up, mi.Float(GLASS), mi.Float(alpha), mi.Float(0.5), seeds), analyser
    )
    dr.eval(rough)
    mirrored = ~np.array(rough.transmitted)
    assert 0.02 < mirrored.mean() < 0.2
    for coin, chosen in ((0.0, mirrored), (1.0 - 2 * EPS, ~mirrored)):
        smooth = scatter_polarised(
            InterfaceHit(wi, up, up, mi.Float(GLASS), mi.Float(0.0), mi.Float(coin), mi.UInt32(1)), analyser
        )
        expected = np.array(smooth.weight, np.float64).reshape(4, 4, 1)
        found = np.array(rough.weight, np.float64)[..., chosen]
        # Facets lean by the roughness or so, which is divided by the tangent of the angle where planes turn.
        assert np.median(np.abs(found - expected).max((0, 1))) < 5 * alpha


def unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def field_event(arriving: np.ndarray, leaving: np.ndarray, facet: np.ndarray, eta: np.ndarray, mirrored: np.ndarray):
    """What a facet does to the electric field, (n, 3, 3): Chipman's polarisation ray tracing, which has no frames.

    `leaving` is on the side of the facet's normal; light and path are reversible, so its angle tells the amplitudes.
    """
    s, p = amplitudes(np.arccos(np.clip((leaving * facet).sum(-1), 0.0, 1.0)), eta)
    passed = np.sqrt(np.maximum(1.0 - np.abs([s, p]) ** 2, 0.0))
    s, p = np.where(mirrored, s, passed[0]), np.where(mirrored, p, passed[1])
    across = unit(np.cross(facet, leaving))
    into, out = np.cross(arriving, across), np.cross(leaving, across)
    by_s, by_p = np.einsum("ni,nj->nij", across, across), np.einsum("ni,nj->nij", out, into)
    return s[:, None, None] * by_s + p[:, None, None] * by_p


def mueller_of(field: np.ndarray, x_in: np.ndarray, k_in: np.ndarray, x_out: np.ndarray, k_out: np.ndarray):
    """Mueller matrices (n, 4, 4) of what turns fields into others, in frames given by x axis and direction."""
    to = np.stack([x_out, np.cross(k_out, x_out)], axis=1)
    jones = to @ field @ np.stack([x_in, np.cross(k_in, x_in)], axis=2)
    # E^dagger sigma E are s0 to s3 of fields that go with exp(-i omega t).
    sigma = np.array([[[1, 0], [0, 1]], [[1, 0], [0, -1]], [[0, 1], [1, 0]], [[0, 1j], [-1j, 0]]])
    return 0.5 * np.einsum("iab,nbc,jcd,nad->nij", sigma, jones, sigma, jones.conj()).real


def test_a_walk_over_many_facets_turns_the_electric_field_facet_by_facet(polarised):
    """The same walk step by step; what becomes of the field in three dimensions, in float64 NumPy."""
    import drjit as dr
    import mitsuba as mi

    def rows(value) -> np.ndarray:
        array = np.array(value, np.float64)
        return np.broadcast_to(array.T, (count, 3)) if array.ndim > 1 else np.broadcast_to(array, count)

    count, alpha, analyser = 4000, mi.Float(0.8), mi.Vector4f(1.0, 0.3, -0.5, 0.2)
    wi, first = vector(unit(np.array([0.5, 0.6, 0.4]))), vector(unit(np.array([0.6, -0.5, 0.0])))
    seeds = mi.sample_tea_32(dr.arange(mi.UInt32, count), mi.UInt32(4))[0]
    numbers, eta = mi.PCG32(initstate=mi.UInt64(seeds)), mi.Float(1.0 / GLASS)
    direction, height, axis, M = -wi + dr.zeros(mi.Vector3f, count), mi.Float(1.0), first, identity()
    above, walking = dr.full(mi.Bool, True, count), dr.full(mi.Bool, True, count)
    field, facets = np.broadcast_to(np.eye(3), (count, 3, 3)), np.zeros(count, int)
    for _ in range(6):
        sign = dr.select(above, 1.0, -1.0)
        reached, leaves = next_height(sign * direction, sign * height, alpha, numbers.next_float32())
        height = sign * reached
        walking &= ~leaves
        at, coin = mi.Point2f(numbers.next_float32(), numbers.next_float32()), numbers.next_float32()
        facet, ratio = sign * visible_facet(-sign * direction, alpha, at), dr.select(above, eta, dr.rcp(eta))
        left, mirrored, end = polarised_facet_event(StokesFrame(M, axis), -direction, facet, ratio, coin, analyser)
        after, s = end.M, end.axis
        dr.eval(left, mirrored, after, s, facet, ratio, walking)
        change = field_event(-rows(left), -rows(direction), rows(facet), rows(ratio), rows(mirrored).astype(bool))
        on = rows(walking).astype(bool)
        field, facets = np.where(on[:, None, None], field @ change, field), facets + on
        direction, axis, M = (
            dr.select(walking, left, direction),
            dr.select(walking, s, axis),
            dr.select(walking, after, M),
        )
        above = dr.select(walking, above == mirrored, above)

    end, frame = walk_polarised(wi, first, alpha, eta, seeds, analyser)
    gone, x = end.direction, frame.axis
    found = np.moveaxis(np.array(as_matrix(frame.M), np.float64), -1, 0)
    expected = mueller_of(field, rows(x), -rows(gone), rows(first), rows(wi))
    expected /= np.einsum("i,ni->n", [1.0, 0.3, -0.5, 0.2], expected[..., 0])[:, None, None]
    several = (facets > 1) & (facets < 6) & (np.abs(rows(gone) - rows(direction)).max(-1) < 1e-3)
    assert several.sum() > 0.2 * count
    # Rounding grows where a facet is met straight on, which few are.
    error = np.abs(found - expected)[several].max((1, 2))
    assert np.quantile(error, 0.98) < 16 * ROUNDINGS * EPS


# ---- Plates ----


def pile(proofs, plates: int):
    """Level plates of glass in the dark, under a bright upper half of the sky; loaded."""
    bodies, loading, medium = proofs("bodies"), proofs("loading"), Medium(name="glass", eta=GLASS)
    mesh = bodies.box((-5.0, -5.0, 0.0), (5.0, 5.0, 0.002))
    for place in range(1, plates):
        mesh = bodies.both(mesh, bodies.box((-5.0, -5.0, 0.004 * place), (5.0, 5.0, 0.004 * place + 0.002)))
    sky = np.zeros((16, 32, 3))
    sky[:8] = 1.0
    return loading.loaded(loading.interface(mesh, medium), environment=sky, max_depth=1024, rr_depth=1024)


def seen(kernel, direction: np.ndarray, across: np.ndarray, count: int = 20_000) -> np.ndarray:
    """Stokes vectors of paths in one direction over a disc about the origin, x `across`, (count, 4)."""
    import drjit as dr
    import mitsuba as mi

    towards = vector(direction) + dr.zeros(mi.Vector3f, count)
    points = sobol_sampler(dr.arange(mi.UInt32, count), dr.zeros(mi.UInt32, count), 1, 5)
    spin, radius = np.arange(count) * np.pi * (3.0 - np.sqrt(5.0)), 0.045 * np.sqrt((np.arange(count) + 0.5) / count)
    start = np.outer(across, radius * np.cos(spin)) + np.outer(np.cross(direction, across), radius * np.sin(spin))
    ray = mi.Ray3f(mi.Point3f((start - 0.5 * direction[:, None]).astype(np.float32)), towards)
    ray.wavelengths, _ = draw_wavelengths(mi.Float(0.4) + dr.zeros(mi.Float, count))
    # Of spectra the green channel is enough; it is brought to the sky's 1 by a plain look at the sky.
    found = trace(kernel, ray, mi.UnpolarizedSpectrum(1.0), points, kernel.description.picture)
    up = mi.Ray3f(mi.Point3f(0.0, 0.0, 1.0), mi.Vector3f(0.0, 0.0, 1.0) + dr.zeros(mi.Vector3f, count))
    up.wavelengths = ray.wavelengths
    sky = trace(kernel, up, mi.UnpolarizedSpectrum(1.0), points, kernel.description.picture).radiance
    R = mi.mueller.rotate_stokes_basis(-towards, mi.mueller.stokes_basis(-towards), vector(across))
    s0, (s1, s2, s3) = found.radiance[1], (vector[1] for vector in found.polarisation)
    vectors = [s0 / sky[1], (R[1, 1] * s1 + R[1, 2] * s2) / sky[1], (R[2, 1] * s1 + R[2, 2] * s2) / sky[1], s3 / sky[1]]
    dr.eval(vectors)
    return np.array([np.broadcast_to(np.array(vector, np.float64), count) for vector in vectors]).T


def agrees(found: np.ndarray, expected: list[float]) -> bool:
    """Whether the mean of the paths is what is expected, up to rounding and five times its own standard error."""
    error = found.std(0) / np.sqrt(len(found))
    return bool((np.abs(found.mean(0) - expected) < 5.0 * error + 4 * ROUNDINGS * EPS).all())


@pytest.mark.parametrize("plates", [1, 4])
@pytest.mark.parametrize("degrees", [20.0, 56.31, 75.0])
def test_light_through_and_from_a_pile_of_plates_is_polarised_as_stokes_said(polarised, proofs, plates, degrees):
    """Stokes 1862, "On the intensity of the light reflected from or transmitted through a pile of plates"."""
    theta, spin = np.radians(degrees), 0.4
    level, across = np.array([np.cos(spin), np.sin(spin), 0.0]), np.array([-np.sin(spin), np.cos(spin), 0.0])
    shares = [abs(amplitude) ** 2 for amplitude in amplitudes(np.array(theta), GLASS)]
    s, p = ((1.0 - R) / (1.0 + (2 * plates - 1) * R) for R in shares)
    kernel = pile(proofs, plates)
    for side, (of_s, of_p) in ((1.0, (s, p)), (-1.0, (1.0 - s, 1.0 - p))):  # from below through, from above mirrored
        found = seen(kernel, np.sin(theta) * level + [0.0, 0.0, side * np.cos(theta)], across)
        expected = [0.5 * (of_s + of_p), 0.5 * (of_s - of_p), 0.0, 0.0]
        assert agrees(found, expected)
        # A renderer without polarisation would be found out.
        assert not agrees(found, [expected[0], 0.0, 0.0, 0.0])
        assert (np.linalg.norm(found[:, 1:], axis=1) <= found[:, 0] * (1.0 + 16 * ROUNDINGS * EPS)).all()


@pytest.mark.slow
def test_drawn_scenes_render_with_labels_and_no_light_is_more_than_wholly_polarised(polarised, drawn):
    import mitsuba as mi

    spectra = {"spectral": mi.is_spectral, "dispersion": mi.is_spectral, "spp": 16}
    scene = drawn(5, vessels={"rough_probability": 0.5, "chord_error": 1e-4}, picture=spectra)
    frame = Renderer(scene, mi.variant()).frame(0)
    assert np.isfinite(frame.left).all()
    assert frame.left.mean() > 0.01
    stokes = trace_stokes(load(scene), scene.cameras[0], seed=2)
    assert np.isfinite(stokes).all()
    bright = luminance(stokes)[..., None]
    degree = degree_of_polarisation(bright)
    assert degree.max() < 1.0 + 16 * ROUNDINGS * EPS
    assert degree.max() > 0.05


@pytest.mark.parametrize("alpha", [0.0, 0.3])
def test_clear_glass_is_invisible_and_polarises_nothing_in_a_white_furnace(polarised, proofs, alpha):
    """Unpolarised light from everywhere stays what it is: the second law of thermodynamics."""
    bodies, loading, optics = proofs("bodies"), proofs("loading"), proofs("energy")
    outer, inner = bodies.shell(0.05, 0.046)
    filled = loading.loaded(
        loading.interface(outer, optics._GLASS, roughness=alpha),
        loading.interface(inner, optics._GLASS, optics._WATER, roughness=alpha, part="wet_wall"),
        max_depth=1024,
        rr_depth=1024,
    )
    found = seen(filled, np.array([0.6, 0.64, 0.48]), np.array([0.8, -0.48, -0.36]), 5000)
    # Of a walk with 32 facets fewer than one in a thousand is cut, as in variants without polarisation.
    assert found[:, 0].mean() == pytest.approx(1.0, abs=2e-3)
    assert agrees(found[:, 1:], [0.0, 0.0, 0.0])
    assert (np.linalg.norm(found[:, 1:], axis=1) <= found[:, 0] * (1.0 + 64 * ROUNDINGS * EPS)).all()
    assert np.abs(found[:, 1:]).max() > 0.01
