"""Derivatives of what paths bring back."""

from __future__ import annotations

import importlib

import pytest


@pytest.mark.parametrize("angle", [0.0, 40.0])
def test_light_changes_with_absorption_as_the_sum_of_all_reflections_does(law, holds, angle):
    holds(law("picture_derivatives").absorption(100_000, angles=(angle,)))


def test_light_changes_with_its_surroundings_in_proportion(law, holds):
    holds(law("picture_derivatives").light(100_000))


@pytest.mark.slow
def test_light_changes_with_roughness_as_central_differences_do(law, holds):
    holds(law("picture_derivatives").roughness(400_000))


@pytest.mark.slow
def test_lengths_that_are_half_forgotten_are_found(law, broken, monkeypatch):
    replay = importlib.import_module("glassware.render.derivatives.replay")
    right = replay.add_absorption
    monkeypatch.setattr(
        replay, "add_absorption", lambda tape, medium, length, *rest: right(tape, medium, 0.5 * length, *rest)
    )
    assert broken(law("picture_derivatives").absorption(20_000, angles=(0.0,)))


@pytest.mark.slow
def test_a_wrong_score_is_found(law, broken, monkeypatch):
    replay = importlib.import_module("glassware.render.derivatives.replay")
    right = replay.add_roughness
    monkeypatch.setattr(
        replay,
        "add_roughness",
        lambda tape, table, surface, score, *rest: right(tape, table, surface, 0.5 * score, *rest),
    )
    assert broken(law("picture_derivatives").roughness(400_000))
