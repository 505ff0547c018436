"""What the denoiser is told: colour and normal of the first rough surface, seen through glass, averaged over pixels."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import maximum_filter, minimum_filter

from glassware.procedural.description.material import ProceduralTexture, UniformTexture
from glassware.render.labels.geometry import trace_geometry
from glassware.render.labels.refraction import trace_refraction
from glassware.render.pictures.guides import trace_guides
from glassware.render.scene.loaded_scene import load

DARK, BRIGHT, PLAIN = (0.1, 0.1, 0.1), (0.9, 0.9, 0.9), (0.2, 0.5, 0.8)


@pytest.fixture(scope="module")
def on_table(backend, glasses):
    """(texture, repeats, other looks) -> the glasses on a table with it, loaded."""

    def make(texture, repeats: float = 1.0, **look: float):
        looks = {"base_colour": texture, "repeats": repeats, "metallic": 0.0} | look
        material = glasses.table.material.model_copy(update=looks)
        return load(glasses.model_copy(update={"table": glasses.table.model_copy(update={"material": material})}))

    return make


def _ids(kernel) -> np.ndarray:
    return trace_geometry(kernel, kernel.description.cameras[0]).id


def _only(which: np.ndarray) -> np.ndarray:
    """Which pixels have neighbours of the same kind alone."""
    return minimum_filter(which.astype(int), size=3) > 0


def _guides(kernel):
    return trace_guides(kernel, kernel.description.cameras[0], "left")


def test_glass_is_where_the_geometry_has_it(on_table):
    kernel = on_table(UniformTexture(colour=PLAIN))
    glass = _guides(kernel).glass
    vessels = np.isin(_ids(kernel), [vessel.id for vessel in kernel.description.vessels])
    assert glass[_only(vessels)].all()
    assert not glass[maximum_filter(vessels.astype(int), size=3) == 0].any()
    assert 50 < vessels.sum() < 0.5 * vessels.size


def test_a_plain_table_shows_its_colour_and_its_normal(on_table):
    kernel = on_table(UniformTexture(colour=PLAIN))
    guides = _guides(kernel)
    albedo, normal = guides.albedo, guides.normal
    table = _only(_ids(kernel) == 1)
    assert table.sum() > 100
    # The principled model's diffuse reflectance is the base colour.
    np.testing.assert_allclose(albedo[table], np.broadcast_to(PLAIN, albedo[table].shape), atol=1e-3)
    np.testing.assert_allclose(normal[table], np.broadcast_to([0.0, 0.0, 1.0], normal[table].shape), atol=1e-3)


def test_a_pattern_finer_than_pixels_shows_its_mean_and_no_moire(on_table):
    chequered = ProceduralTexture(kind="checker", colours=(DARK, BRIGHT), seed=1, resolution=64)
    kernel = on_table(chequered, 400.0)
    albedo = _guides(kernel).albedo[_only(_ids(kernel) == 1)][:, 0]
    # 16 independent places would leave 0.4 / sqrt(16) = 0.1 of noise; four alone leave 0.2.
    assert albedo.std() < 0.4 / np.sqrt(16)
    assert abs(albedo.mean() - 0.5) < 4 * 0.4 / np.sqrt(16 * len(albedo))


def test_the_first_four_rays_alone_would_not_do(on_table, monkeypatch):
    from glassware.render.pictures import guides

    monkeypatch.setattr(guides, "_MAX_RANGE", np.inf)
    chequered = ProceduralTexture(kind="checker", colours=(DARK, BRIGHT), seed=1, resolution=64)
    kernel = on_table(chequered, 400.0)
    assert _guides(kernel).albedo[_only(_ids(kernel) == 1)][:, 0].std() > 0.4 / np.sqrt(16)


def test_behind_smooth_glass_lies_what_the_refracted_ray_reaches_and_a_mirrored_share(on_table):
    kernel = on_table(UniformTexture(colour=PLAIN))
    guides = _guides(kernel)
    albedo, glass = guides.albedo, guides.glass
    end = trace_refraction(kernel, [kernel.description.cameras[0]])[0]
    shown = _only(glass) & _only(end.id == 1)
    assert shown.sum() > 30
    passed = end.transmittance[shown] * PLAIN
    # The mirrored share is what the first surface does not let pass, of surroundings no brighter than 1. The refracted
    # ray is the pixel's centre, the guide its mean: single pixels differ, their median hardly.
    mirrored = np.median(albedo[shown] - passed, axis=0)
    assert (mirrored > 0.0).all()
    assert (mirrored < 0.2).all()


@pytest.mark.parametrize(
    ("roughness", "metallic", "shines"),
    [
        (0.2, 0.0, True),
        *(pytest.param(*case, marks=pytest.mark.slow) for case in ((0.6, 0.0, False), (0.7, 1.0, True))),
    ],
)
def test_polish_is_where_a_smooth_or_metal_prop_is_seen_first(backend, drawn, roughness, metallic, shines):
    view = {"views": 1, "width": 96, "height": 64, "slack": (1.0, 1.0)}
    scene = drawn(12, vessel_count=(0, 0), prop_count=(2, 2), cameras=view)
    look = {"roughness": roughness, "metallic": metallic}
    first, *others = scene.props
    first = first.model_copy(update={"material": first.material.model_copy(update=look)})
    dull = {"roughness": 0.9, "metallic": 0.0}
    others = [prop.model_copy(update={"material": prop.material.model_copy(update=dull)}) for prop in others]
    kernel = load(scene.model_copy(update={"props": (first, *others)}))
    polished, inside = _guides(kernel).polished, _ids(kernel) == first.id
    assert _only(inside).sum() > 20
    assert (polished[_only(inside)] == shines).all()
    assert not polished[maximum_filter(inside.astype(int), size=3) == 0].any()


def test_a_polished_table_counts_as_any_other(on_table):
    assert not _guides(on_table(UniformTexture(colour=PLAIN), roughness=0.1)).polished.any()


def test_the_object_at_the_centre_of_each_pixel_is_that_of_the_geometry(on_table):
    kernel = on_table(UniformTexture(colour=PLAIN))
    np.testing.assert_array_equal(_guides(kernel).instance, _ids(kernel))
