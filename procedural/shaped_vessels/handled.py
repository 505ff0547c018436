"""Mugs, cups and jugs: vessels with a handle, and with a lip to pour from."""

from __future__ import annotations

import numpy as np

from .forms import denser, lipped, round_form
from .shapes import Drawn, Handle, Shape
from .tumblers import faceted

#: Handles of mugs and cups: ends over the height; reach that leaves room for a finger of 20 mm beside its half
#: thickness; half axes [m]. As on glass mugs of 0.2 to 0.5 l.
MUG_LOW, MUG_HIGH, MUG_REACH, MUG_DEPTH, MUG_WIDTH = (0.16, 0.28), (0.74, 0.86), (0.024, 0.032), (3.6e-3, 5e-3), 1.5
#: The same of cups, whose handles one holds with two fingers.
CUP_LOW, CUP_HIGH, CUP_REACH, CUP_DEPTH, CUP_WIDTH = (0.28, 0.4), (0.74, 0.86), (0.016, 0.022), (2.6e-3, 3.6e-3), 1.4
#: The same of jugs, which a hand holds.
JUG_LOW, JUG_HIGH, JUG_REACH, JUG_DEPTH, JUG_WIDTH = (0.25, 0.38), (0.78, 0.88), (0.032, 0.042), (4.5e-3, 6e-3), 1.5
#: How much the curve's control points lie beyond the ends, of their distance; growth towards the wall [1].
BEYOND, GROWTH = (0.0, 0.25), (0.25, 0.7)
#: Share of mugs with facets.
FACETED_MUGS = 0.3
#: Lip of a jug: how far it stands out, of the rim's radius; its width [rad]; where it begins, of the height.
JUG_LIP, JUG_LIP_WIDTH, JUG_LIP_LOW = (0.14, 0.28), (0.24, 0.4), (0.78, 0.88)
#: Columns within a lip, and the angle that they cover, of its width [1].
LIP_COLUMNS, LIP_COVER = 41, 3.2


def mug(rng: np.random.Generator, drawn: Drawn) -> Shape:
    """Draw a mug: round or faceted, with a handle."""
    plain = rng.random() >= FACETED_MUGS
    shape = Shape(*[round_form(drawn.segments)] * 2) if plain else faceted(rng, drawn)
    handle = draw_handle(rng, drawn, (MUG_LOW, MUG_HIGH), MUG_REACH, MUG_DEPTH, MUG_WIDTH)
    return Shape(shape.form, shape.measured, handle=handle)


def cup(rng: np.random.Generator, drawn: Drawn) -> Shape:
    """Draw a cup with a small handle."""
    form = round_form(drawn.segments)
    handle = draw_handle(rng, drawn, (CUP_LOW, CUP_HIGH), CUP_REACH, CUP_DEPTH, CUP_WIDTH)
    return Shape(form, form, handle=handle)


def jug(rng: np.random.Generator, drawn: Drawn) -> Shape:
    """Draw a jug: a lip at +x and a handle at -x."""
    low, width = rng.uniform(*JUG_LIP_LOW) * drawn.height, rng.uniform(*JUG_LIP_WIDTH)
    reach = rng.uniform(*JUG_LIP) * drawn.radius(drawn.height)
    form = lipped(round_form(drawn.segments), reach, width, low, drawn.height)
    form = denser(form, LIP_COVER * width, LIP_COLUMNS)
    handle = draw_handle(rng, drawn, (JUG_LOW, JUG_HIGH), JUG_REACH, JUG_DEPTH, JUG_WIDTH)
    return Shape(form, form, handle=handle)


def draw_handle(
    rng: np.random.Generator,
    drawn: Drawn,
    ends: tuple[tuple[float, float], tuple[float, float]],
    reach: tuple[float, float],
    depth: tuple[float, float],
    ratio: float,
) -> Handle:
    """Draw a handle between ranges of its ends, of the height; `ratio` is how much wider than deep it is."""
    low, high = (rng.uniform(*limits) * drawn.height for limits in ends)
    thick = rng.uniform(*depth)
    return Handle(
        low=low,
        high=high,
        reach=rng.uniform(*reach),
        depth=thick,
        width=thick * rng.uniform(1.0, ratio),
        rise=rng.uniform(*BEYOND) * (high - low),
        drop=rng.uniform(*BEYOND) * (high - low),
        growth=rng.uniform(*GROWTH),
    )
