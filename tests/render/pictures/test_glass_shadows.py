"""Pictures in which glass casts neither shadows nor caustics, as some renderers draw it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import binary_dilation

from glassware.core.errors import InputError
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.scene import Scene
from glassware.render.derivatives.gradients import picture_and_gradients
from glassware.render.pictures.picture import NoisyImage, trace_picture
from glassware.render.scene.loaded_scene import load


@pytest.fixture(scope="module")
def filled(backend, drawn, all_clear) -> Scene:
    """Two filled vessels among props, nothing opaque in them; every pixel gets the same samples in all pictures."""
    vessels = all_clear | {"fill_probability": 1.0, "chord_error": 5e-5, "rough_probability": 0.0}
    return drawn(5, vessels=vessels).model_copy(update={"picture": Picture(spp=8, light="path", adaptive=False)})


def _picture(scene: Scene, **changes: bool) -> NoisyImage:
    scene = scene.model_copy(update={"picture": scene.picture.model_copy(update=changes)})
    return trace_picture(load(scene), scene.cameras[0], "left", 3)


def test_light_reaches_opaque_surfaces_as_if_there_were_no_glass(filled) -> None:
    without, bare = _picture(filled, glass_shadows=False), _picture(filled.without(*(v.name for v in filled.vessels)))
    beside = ~binary_dilation(without.guides.glass, iterations=2)
    assert 0.3 < beside.mean() < 0.95
    np.testing.assert_allclose(without.radiance[beside], bare.radiance[beside], rtol=1e-4, atol=1e-6)
    assert without.violations == 0
    lit = _picture(filled)
    changed = np.abs(lit.radiance - bare.radiance)[beside].max(-1) > 0.05 * bare.radiance[beside].max(-1)
    assert changed.sum() > 40  # pixels of its shadow


def test_glass_itself_still_refracts(filled) -> None:
    without, bare = _picture(filled, glass_shadows=False), _picture(filled.without(*(v.name for v in filled.vessels)))
    glass = without.guides.glass
    changed = np.abs(without.radiance - bare.radiance)[glass].max(-1) > 0.05 * bare.radiance[glass].max(-1)
    assert changed.mean() > 0.7


def test_stored_light_and_derivatives_do_not_do_without_shadows(backend, filled) -> None:
    with pytest.raises(ValueError, match="glass_shadows: expected yes with light shared, found no"):
        Picture(glass_shadows=False, light="shared")
    with pytest.raises(ValueError, match="air_gap: expected no with keep_light, found yes"):
        Picture(air_gap=True, keep_light=True)
    picture = filled.picture.model_copy(update={"glass_shadows": False})
    loaded, camera = load(filled.model_copy(update={"picture": picture})), filled.cameras[0]
    adjoint = np.ones((camera.height, camera.width, 3))
    with pytest.raises(InputError, match=r"picture\.glass_shadows: expected yes for derivatives, found no"):
        picture_and_gradients(loaded, camera, "left", 3, adjoint)
