"""Where rays go: Snell's law in slabs, prisms, lenses, water and drawn glasses."""

from __future__ import annotations

import importlib

import numpy as np
import pytest


def test_rays_cross_a_slab_as_snell_says(law, holds):
    holds(law("snell").slab(np.arange(0.0, 86.0, 5.0)))


def test_rays_cross_a_prism_as_snell_says_in_both_ray_loops(law, holds):
    holds(law("snell").prism_angles(np.arange(36.0, 81.0, 4.0)))


def test_wavelengths_leave_a_prism_by_the_sellmeier_index(law, holds):
    snell = law("snell")
    checks = snell.dispersed_prism()
    holds(checks)
    # Lines are told apart: half a degree lies between the first and the last.
    assert abs(checks[0].measured - checks[-1].measured) > 100 * max(check.limit for check in checks)


def test_water_looks_shallower_than_it_is(law, holds):
    holds(law("snell").apparent_depth(np.array([0.5, 20.0, 45.0, 70.0])))


def test_a_ball_and_a_plano_convex_lens_have_their_focal_lengths(law, holds):
    lenses = law("lenses")
    holds(lenses.ball_lens(subdivisions=5) + lenses.plano_convex_lens())


def test_a_glass_of_water_bends_light_by_air_glass_and_water_in_order(law, holds):
    holds(law("lenses").glass_of_water())


@pytest.mark.slow
def test_a_drawn_glass_of_water_agrees_with_a_second_tracer(law, holds):
    holds(law("vessels").second_tracer(40))


@pytest.mark.parametrize("wrong", [1.0 + 1e-5, 1.0 - 1e-5])
def test_an_index_wrong_in_the_fifth_digit_is_found(law, broken, monkeypatch, wrong):
    dielectric = importlib.import_module("glassware.render.interfaces.dielectric")
    right = dielectric.refracted
    monkeypatch.setattr(dielectric, "refracted", lambda wi, m, ci, ct, eta: right(wi, m, ci, ct, eta * wrong))
    assert broken(law("snell").slab(np.arange(5.0, 86.0, 10.0)))


def test_a_gap_of_air_between_water_and_glass_is_found(law, broken, monkeypatch):
    lenses, bodies = law("lenses"), law("bodies")
    right = lenses.loaded

    def with_gap(outside, wet):
        bore = float(wet.mesh.bounds[1, 0])
        water = bodies.tube(bore - 1e-5, 0.09, 2048, "water")
        dry = wet.model_copy(update={"front": outside.front})
        return right(outside, dry, lenses.interface(water, wet.front, part="liquid_surface"))

    monkeypatch.setattr(lenses, "loaded", with_gap)
    assert broken(lenses.glass_of_water())


def test_a_bore_wrong_by_a_hundredth_of_a_millimetre_is_found(law, broken, monkeypatch):
    lenses = law("lenses")
    right = lenses.tube
    monkeypatch.setattr(
        lenses, "tube", lambda r, *rest, **named: right(r - 1e-5 * named.get("inwards", 0), *rest, **named)
    )
    assert broken(lenses.glass_of_water())
