"""Drawn props."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from pydantic import ValidationError

from glassware.procedural.props.draw import PropSettings, draw_prop
from glassware.procedural.props.mesh_files import mesh_files


def _draw(seed: int, settings: PropSettings | None = None, **files: object) -> object:
    return draw_prop(np.random.default_rng(seed), settings or PropSettings(), id=2, name="prop-0", **files)


def test_a_prop_keeps_to_the_sizes_asked_for_and_says_its_own() -> None:
    for seed in range(40):
        prop = _draw(seed, PropSettings(smallest=0.08, largest=0.1))
        # 10 % less where rounding takes a cone's corner.
        assert 0.072 < max(prop.size) < 0.1001
        assert prop.size == pytest.approx(np.ptp(prop.mesh.bounds, axis=0))
        assert np.array_equal(prop.world_T_object, np.eye(4))
        assert prop.material.repeats == round(prop.material.repeats)


def test_a_prop_depends_on_its_generator_alone() -> None:
    first, again = _draw(3), _draw(3)
    assert np.array_equal(first.mesh.vertices, again.mesh.vertices)
    assert first.material == again.material


def test_the_share_of_files_is_kept_to(tmp_path: Path) -> None:
    trimesh.creation.box((0.1, 0.1, 0.05)).export(tmp_path / "block.stl")
    files = mesh_files(tmp_path)
    assert all(_draw(s, PropSettings(file_share=1.0), mesh_files=files).category == "block.stl" for s in range(10))
    assert all(_draw(s, PropSettings(file_share=0.0), mesh_files=files).category != "block.stl" for s in range(10))
    assert all(_draw(s, PropSettings(file_share=1.0)).category != "block.stl" for s in range(10))


def test_a_mesh_without_texture_coordinates_gets_some(tmp_path: Path) -> None:
    trimesh.creation.box((0.1, 0.1, 0.05)).export(tmp_path / "block.stl")
    assert _draw(1, PropSettings(file_share=1.0), mesh_files=mesh_files(tmp_path)).mesh.uv is not None


def test_impossible_sizes_are_refused() -> None:
    with pytest.raises(ValidationError, match="at most largest"):
        PropSettings(smallest=0.2, largest=0.1)
