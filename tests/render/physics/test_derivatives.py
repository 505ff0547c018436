"""Derivatives of the refracted ray."""

from __future__ import annotations

import importlib


def test_a_slabs_derivatives_are_those_of_snells_and_beers_laws(law, holds):
    holds(law("derivatives").slab())


def test_a_balls_derivatives_are_those_of_central_differences(law, holds):
    holds(law("derivatives").ball_by_differences())


def test_directions_cut_off_from_the_derivative_are_found(law, broken, monkeypatch):
    import drjit as dr

    dielectric = importlib.import_module("glassware.render.interfaces.dielectric")
    right = dielectric.refracted
    monkeypatch.setattr(dielectric, "refracted", lambda *given: dr.detach(right(*given)))
    derivatives = law("derivatives")
    assert broken(derivatives.slab())
    assert broken(derivatives.ball_by_differences())
