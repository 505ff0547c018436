"""Prints on a table are seen in pictures, by both ways to light them, and in no label."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from glassware.procedural.description.material import OpaqueMaterial, UniformTexture
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.scene import Scene
from glassware.procedural.description.surroundings import TablePrint
from glassware.procedural.optics.catalogue import glass_named
from glassware.procedural.primitives import bodies, scenes

#: Reflectance of the table, and of the sheet on it: 0.3 m x 0.2 m in its middle.
DARK, PALE = 0.2, 0.6


def _scene(printed: bool, light: str = "path") -> Scene:
    table = scenes.board((0.8, 0.6, 0.03), scenes.matte((DARK, DARK, DARK)))
    paper = OpaqueMaterial(name="paper", base_colour=UniformTexture(colour=(PALE, PALE, PALE)), roughness=1.0)
    sheet = TablePrint(kind="sheet", centre=(0.0, 0.0), angle=0.3, size=(0.3, 0.2), material=paper)
    if printed:
        table = table.model_copy(update={"prints": (sheet,)})
    picture = Picture.model_validate({"spp": 16, "light": light, "denoise": False, "layers": 2, "refraction": True})
    ball = bodies.ball(0.03, glass_named("soda-lime glass"), (0.05, 0.0, 0.0301))
    view = scenes.camera((0.0, -0.5, 0.6), width=48, height=36)
    return scenes.scene([ball], [view], table=table, picture=picture)


def test_prints_change_no_label(backend) -> None:
    import glassware as gw

    frames = [gw.Renderer(_scene(printed)).frame(0) for printed in (False, True)]
    labels = [dataclasses.asdict(part) for frame in frames for part in (frame.geometry, frame.layers, frame.refraction)]
    count = 0
    for without, having in zip(labels[:3], labels[3:], strict=True):
        for name, values in without.items():
            if isinstance(values, np.ndarray):
                np.testing.assert_array_equal(having[name], values, err_msg=name)
                count += 1
    assert count > 5
    assert not np.array_equal(frames[0].left, frames[1].left)


@pytest.mark.slow
@pytest.mark.parametrize("light", ["path", "shared"])
def test_a_print_is_as_bright_as_its_reflectance_says(backend, light: str) -> None:
    import glassware as gw

    dark, pale = (np.asarray(gw.Renderer(_scene(printed, light)).frame(0).left, float) for printed in (False, True))
    ratio = (pale / dark).mean(axis=2)
    # On the sheet, left of the ball; and on the table between sheet and camera.
    assert np.median(ratio[16:20, 17:22]) == pytest.approx(PALE / DARK, rel=0.1)
    assert np.median(ratio[29:34, 18:30]) == pytest.approx(1.0, rel=0.05)
