"""Our path tracer against Mitsuba's own `path`, written by others, on the same loaded scene."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import t as student

from glassware.procedural.description.picture import Picture
from glassware.render.pictures.picture import trace_picture
from glassware.render.scene.loaded_scene import load
from glassware.render.scene.rays import pinhole, pixel_rays

#: Independent pictures of each renderer; their spread is the variance that differences are judged by.
PASSES, SPP = 12, 16
#: Side of the blocks that are compared [px]. A sum over many pixels and samples is nearly normal.
BLOCK = 8
#: Chance that two right renderers fail with other seeds.
SIGNIFICANCE = 1e-3
#: Height of every vessel over the table [m]. Mitsuba starts rays 1e-4 (1 + |p|) off a surface, 0.1 mm: in the true gap
#: under a glass, as thin as that, its rays pass through the table. A centimetre is beyond doubt.
LIFTED = 0.01


@pytest.fixture(scope="module")
def lifted(backend, drawn, clear):
    """Smooth clear glasses, filled and floating, and a prop."""

    def raised(body):
        pose = body.world_T_object.copy()
        pose[2, 3] += LIFTED
        return body.model_copy(update={"world_T_object": pose})

    scene = clear(drawn(31, vessel_count=(3, 3), prop_count=(1, 1), cameras={"views": 15, "width": 48, "height": 32}))
    # Thicker walls than these 0.1 mm do not care for the offset either.
    return load(
        scene.model_copy(
            update={
                "vessels": tuple(raised(item) for item in scene.vessels),
                # A straw and a print go with the vessel that they stand in and belong to.
                "props": tuple(raised(item) if item.within or item.part_of else item for item in scene.props),
                "picture": Picture(spp=SPP, max_depth=64, rr_depth=64),
                "cameras": scene.cameras[-1:],
            }
        ),
        glass_for_mitsuba=True,
    )


def _theirs(kernel, seed: int) -> np.ndarray:
    """A picture by Mitsuba's integrator along the same camera rays as ours, (H, W, 3)."""
    import drjit as dr
    import mitsuba as mi

    camera = kernel.description.cameras[0]
    count = camera.width * camera.height * SPP
    # One more: theirs counts the camera's segment, and gathers light where ours has stopped.
    integrator = mi.load_dict({"type": "path", "max_depth": 65, "rr_depth": 1000})
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed, count)
    ray, _ = pixel_rays(pinhole(camera), dr.arange(mi.UInt32, count) // SPP, sampler.next_2d() - 0.5)
    colour, *_ = integrator.sample(kernel.mi_scene, sampler, mi.RayDifferential3f(ray))
    dr.eval(colour)
    return np.array(colour).T.reshape(camera.height, camera.width, SPP, 3).mean(2, dtype=np.float64)


def _blocks(picture: np.ndarray) -> np.ndarray:
    height, width, _ = picture.shape
    return picture.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3).mean((1, 3))


def _p_values(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Welch's two-sided test of equal means, block by block; both are (passes, ...)."""
    a, b = one.var(0, ddof=1) / len(one), two.var(0, ddof=1) / len(two)
    degrees = (a + b) ** 2 / (a**2 / (len(one) - 1) + b**2 / (len(two) - 1))
    return 2.0 * student.sf(np.abs(one.mean(0) - two.mean(0)) / np.sqrt(a + b), degrees)


def _lowest(p: np.ndarray) -> float:
    """The p-value of the worst of all blocks, by Šidák's correction."""
    return 1.0 - (1.0 - float(p.min())) ** p.size


@pytest.fixture(scope="module")
def pictures(lifted):
    camera = lifted.description.cameras[0]
    ours = [_blocks(trace_picture(lifted, camera, "left", 100 + i).radiance.astype(float)) for i in range(PASSES)]
    theirs = [_blocks(_theirs(lifted, 200 + i)) for i in range(PASSES)]
    # One number a block: colours of a block are no independent measurements.
    return np.stack(ours).mean(-1), np.stack(theirs).mean(-1)


def test_pictures_agree_with_mitsubas_block_by_block(pictures):
    assert _lowest(_p_values(*pictures)) > SIGNIFICANCE


def test_mean_light_agrees_with_mitsubas(pictures):
    ours, theirs = (picture.mean((1, 2))[:, None] for picture in pictures)
    assert _lowest(_p_values(ours, theirs)) > SIGNIFICANCE
    # The test can tell a difference of a few per cent.
    error = np.sqrt((ours.var(ddof=1) + theirs.var(ddof=1)) / PASSES)
    assert error < 0.01 * theirs.mean()


@pytest.mark.slow
def test_the_comparison_sees_a_glass_of_another_index(pictures, lifted):
    def heavier(medium):
        return medium.model_copy(update={"eta": medium.eta + 0.3}) if medium.eta > 1.4 else medium

    def changed(vessel):
        parts = [
            part.model_copy(update={"front": heavier(part.front), "back": heavier(part.back)})
            for part in vessel.interfaces
        ]
        return vessel.model_copy(update={"interfaces": tuple(parts)})

    scene = lifted.description
    kernel = load(scene.model_copy(update={"vessels": tuple(changed(item) for item in scene.vessels)}))
    other = [trace_picture(kernel, scene.cameras[0], "left", 300 + i).radiance.astype(float) for i in range(PASSES)]
    assert _lowest(_p_values(np.stack([_blocks(item) for item in other]).mean(-1), pictures[1])) < SIGNIFICANCE
