"""How much light: Fresnel, Beer and Lambert, white furnaces, radiance in glass, reciprocity."""

from __future__ import annotations

import importlib
from dataclasses import replace

import numpy as np
import pytest


def test_interfaces_mirror_and_let_through_what_fresnel_says(law, holds):
    fresnel = law("fresnel")
    holds(fresnel.reflected_fractions(1 << 16) + fresnel.refracted_share())


def test_reflection_becomes_total_at_the_critical_angle(law, holds):
    holds(law("fresnel").critical_angle())


def test_brewsters_angle_is_where_mirrored_and_refracted_rays_are_perpendicular(law, holds):
    holds(law("fresnel").brewster_angle())


def test_an_index_wrong_by_a_part_in_a_thousand_is_found_in_the_reflectance(law, broken, monkeypatch):
    fresnel = law("fresnel")
    right = fresnel.reflectance
    monkeypatch.setattr(fresnel, "reflectance", lambda theta, eta: right(theta, eta * 1.001))
    assert broken(fresnel.reflected_fractions(1 << 16))


def test_media_absorb_as_beer_and_lambert_say(law, holds):
    holds(law("energy").beer_lambert(50_000))


def test_absorption_wrong_by_a_part_in_a_thousand_is_found(law, broken, monkeypatch):
    kernel = importlib.import_module("glassware.render.scene.surfaces")
    right = kernel.surface_table

    def wrong(*given):
        table = right(*given)
        return replace(table, sigma_a_rgb=table.sigma_a_rgb * 1.001)

    monkeypatch.setattr(importlib.import_module("glassware.render.scene.loaded_scene"), "surface_table", wrong)
    assert broken(law("energy").beer_lambert(1000, lengths=(0.05,)))


def test_straight_rays_through_parallel_walls_and_a_ball_lose_what_fresnel_snell_and_beer_say(law, holds):
    transmittance = law("straight_transmittance")
    holds(transmittance.walls(np.radians(np.arange(0.0, 86.0, 5.0))) + transmittance.absorbing_ball())


def test_an_absorption_along_the_straight_length_is_found(law, broken, monkeypatch):
    geometry = importlib.import_module("glassware.render.labels.geometry")
    monkeypatch.setattr(geometry, "_path_length_factor", lambda *given: 1.0)
    assert broken(law("straight_transmittance").walls(np.radians(np.array([45.0]))))


def test_clear_glass_is_invisible_in_a_white_furnace_smooth_and_rough_empty_and_filled(law, holds):
    holds(law("energy").furnace(5_000))


@pytest.mark.parametrize("roughness", [0.0, 0.2])
def test_drawn_vessels_are_invisible_in_a_white_furnace_with_default_settings(law, holds, roughness):
    holds(law("vessels").default_furnace(50_000, roughness))


def test_light_lost_at_interfaces_is_found_in_the_furnace(law, broken, monkeypatch):
    integrator = importlib.import_module("glassware.render.pictures.integrator")
    right = integrator.scatter

    def lossy(*given):
        event = right(*given)
        return replace(event, weight=event.weight * 0.9999)

    monkeypatch.setattr(integrator, "scatter", lossy)
    assert broken(law("energy").furnace(2_000, alphas=(0.0,)))


def test_radiance_in_glass_is_greater_by_the_index_squared(law, holds):
    energy = law("energy")
    holds(energy.radiance_inside(10_000) + energy.radiance_inside(20_000, alpha=0.2))


def test_rough_interfaces_are_reciprocal(law, holds):
    holds(law("microsurface").reciprocity(300_000))


def test_a_roughness_that_differs_by_side_is_found(law, broken, monkeypatch):
    dielectric = importlib.import_module("glassware.render.interfaces.dielectric")
    right = dielectric.walk
    # Seen from the glass the surface is a tenth rougher.
    monkeypatch.setattr(
        dielectric,
        "walk",
        lambda wi, alpha, eta, *given: right(wi, alpha * (1.1 if eta[0] < 1.0 else 1.0), eta, *given),
    )
    assert broken(law("microsurface").reciprocity(300_000, alphas=(0.2,)))


@pytest.mark.parametrize("alpha", [0.05, 0.1])
def test_light_of_the_first_facet_is_mitsubas_rough_dielectric(law, holds, alpha):
    holds(law("microsurface").first_facet(500_000, alpha=alpha))


def test_another_roughness_than_mitsubas_is_found(law, broken, monkeypatch):
    dielectric = importlib.import_module("glassware.render.interfaces.dielectric")
    right = dielectric.walk
    monkeypatch.setattr(dielectric, "walk", lambda wi, alpha, eta, *given: right(wi, alpha * 1.05, eta, *given))
    assert broken(law("microsurface").first_facet(500_000, alpha=0.1))
