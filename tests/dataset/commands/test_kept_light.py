"""The stored light beside the scene, for whoever asks for it."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.dataset.commands.verify import main as verify
from glassware.dataset.reader import Dataset
from glassware.procedural.description.scene import TABLE_ID
from glassware.procedural.surroundings.environments import bake_environment
from glassware.procedural.surroundings.metering import irradiance


@pytest.mark.slow
def test_kept_light_is_what_arrives_and_belongs_to_the_data_set(render_scene, small, tmp_path):
    """On a bare table under the sky alone it is everywhere what the exposure meter finds by its own integral."""
    bare = ("--vessel-count", 0, 0, "--prop-count", 0, 0, "--lights.max-count", 0, "--cameras.views", 1)
    out = tmp_path / "out"
    told = render_scene("--seed", 7, "--config", small, *bare, "--picture.keep-light", "--out", out)
    assert told.code == 0, told
    assert verify([str(out)]) == 0

    (scene,) = Dataset.open(out).scenes
    light, record = scene.light(), scene.scene()
    assert light is not None
    assert set(np.unique(light.id)) <= {0, TABLE_ID}
    assert (light.paths > 0).all()
    np.testing.assert_allclose(np.linalg.norm(light.normal, axis=1), 1.0, rtol=0, atol=1e-5)
    top = (light.id == TABLE_ID) & (light.position[:, 2] == 0.0) & (light.normal[:, 2] > 0.99)
    assert top.sum() > 1000
    meter = irradiance(bake_environment(record.environment), record.environment.strength, ())
    found = light.irradiance[top].astype(np.float64).mean(0)
    # A path's deviation is less than its mean: the sky has no sun. Four standard errors of all paths together.
    np.testing.assert_allclose(found, meter, rtol=4.0 / np.sqrt(light.paths[top].sum()))


@pytest.mark.slow
def test_no_light_is_kept_unless_asked_for(render_scene, small, tmp_path):
    told = render_scene("--seed", 7, "--config", small, "--picture.light", "shared", "--out", tmp_path / "out")
    assert told.code == 0, told
    (scene,) = Dataset.open(tmp_path / "out").scenes
    assert scene.light() is None
    assert not list((tmp_path / "out").rglob("light.parquet"))


@pytest.mark.parametrize("other", [("--picture.light", "path"), ("--picture.spectral",)])
def test_light_that_is_not_stored_cannot_be_kept(render_scene, small, tmp_path, other):
    told = render_scene("--seed", 7, "--config", small, "--picture.keep-light", *other, "--out", tmp_path / "out")
    assert told.code == 2
    assert "keep_light" in told.errors[-1]
    assert "expected light to be stored" in told.errors[-1]
