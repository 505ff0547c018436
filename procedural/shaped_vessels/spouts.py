"""Teapots: a hollow spout that liquid flows out of, and a handle."""

from __future__ import annotations

import numpy as np

from ..vessels.outline import Outline
from .forms import round_form
from .handled import draw_handle
from .loft import Solid
from .shapes import Drawn, Shape, SpoutTube
from .sweep import bezier, swept

#: Thickness of a spout over the wall's [1].
WALL = 1.04
#: Spout: where it leaves the wall, of the height; how far its end is off the wall [m], and where that is, of the height
#: without the collar of 8 mm; radii at both ends [m].
LOW, OUT, TIP, ROOT, MOUTH = (0.35, 0.5), (0.03, 0.045), (0.98, 1.04), (0.01, 0.014), (0.0065, 0.0075)
#: Handle: ends, of the height; reach and half axes [m].
HANDLE_LOW, HANDLE_HIGH, HANDLE_REACH, HANDLE_DEPTH, HANDLE_WIDTH = (
    (0.2, 0.32),
    (0.7, 0.8),
    (0.03, 0.042),
    (3.2e-3, 4.5e-3),
    1.4,
)
#: How far a spout's tube begins inside the wall, and how far its bore goes on into the inside and beyond its end [m].
_INSIDE, _BORE = 0.012, 0.02
#: Points along a spout [1].
_ALONG = 36


def teapot(rng: np.random.Generator, drawn: Drawn) -> Shape:
    """Draw a teapot: a spout at +x and a handle at -x."""
    form = round_form(drawn.segments)
    handle = draw_handle(rng, drawn, (HANDLE_LOW, HANDLE_HIGH), HANDLE_REACH, HANDLE_DEPTH, HANDLE_WIDTH)
    low, out = rng.uniform(*LOW) * drawn.height, rng.uniform(*OUT)
    tip = rng.uniform(*TIP) * (drawn.height - 0.008)
    spout = SpoutTube(low, (out, tip), rng.uniform(*ROOT), rng.uniform(*MOUTH), WALL * drawn.wall)
    return Shape(form, form, handle=handle, spout=spout)


def spout_solids(spout: SpoutTube, outline: Outline) -> tuple[Solid, Solid]:
    """Return the tube of a spout and its bore, whose normals point into it."""
    radius = float(outline.derivative(np.array([spout.low]), 0)[0])
    x, z = radius + spout.tip[0], spout.tip[1]
    start = np.array([radius - _INSIDE, spout.low - 0.3 * _INSIDE])
    first = np.array([radius + 0.6 * spout.tip[0], spout.low + 0.05 * (z - spout.low)])
    second = np.array([radius + 0.45 * spout.tip[0], spout.low + 0.75 * (z - spout.low)])
    path = bezier(np.array([start, first, second, [x, z]]), _ALONG)
    t = np.linspace(0.0, 1.0, _ALONG)
    radii = spout.mouth + (spout.root - spout.mouth) * (1.0 - t) ** 1.5
    tube = swept(path, radii, radii)
    before, after = path[0] - path[1], path[-1] - path[-2]
    longer = np.concatenate(
        [
            [path[0] + _BORE * before / np.linalg.norm(before)],
            path,
            [path[-1] + 0.5 * _BORE * after / np.linalg.norm(after)],
        ]
    )
    narrow = np.concatenate([[radii[0]], radii, [radii[-1]]]) - spout.wall
    return tube, swept(longer, narrow, narrow, inwards=True)
