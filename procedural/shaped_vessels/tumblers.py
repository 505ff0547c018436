"""Drinking glasses with facets, flutes, ribs, and square or oval cross-sections."""

from __future__ import annotations

import numpy as np

from .forms import (
    Form,
    everywhere,
    falling,
    flute,
    fluted,
    polygon_form,
    rectangle_corners,
    regular_corners,
    ripple,
    rising,
    round_form,
    rounding,
    stretched,
)
from .shapes import Drawn, Shape

#: Facets: number (French bistro glasses have 9, old-fashioned ones 8 or 10, Soviet ones 10 to 20), radius of their edges
#: and height up to which they go, of radius and height; how often they go up to the rim; widening above them.
FACETS, FACET_EDGE, FACET_TOP, FACETS_TO_RIM, FACET_WIDENING = (6, 16), (0.05, 0.2), (0.5, 0.85), 0.3, (1.0, 1.04)
#: Height over which facets and flutes fade [m].
FADE = 0.012
#: Flutes: number, depth of the radius, height where they end, of the height; how often they go up to the rim.
FLUTES, FLUTE_DEPTH, FLUTE_TOP, FLUTES_TO_RIM = (10, 28), (0.03, 0.08), (0.4, 0.9), 0.3
#: Ribs that both sides of the wall follow: number and depth of the radius; the radius of their crests is more than this
#: many walls.
RIBS, RIB_DEPTH, RIB_CREST = (12, 36), (0.015, 0.05), 1.6
#: Squares and rectangles: ratio of sides, radius of corners over that to the nearest side; ellipses: ratio of axes.
SIDE_RATIO, SQUARE_CORNER, OVAL_RATIO = (1.0, 1.35), (0.25, 0.6), (1.2, 1.6)
#: How often a square glass is square, a rectangle, or oval [1].
SQUARE, RECTANGLE = 0.5, 0.7


def faceted(rng: np.random.Generator, drawn: Drawn) -> Shape:
    """Draw facets around a round inside."""
    sides = int(rng.integers(FACETS[0], FACETS[1] + 1))
    edge, top, widening = rng.uniform(*FACET_EDGE), rng.uniform(*FACET_TOP), rng.uniform(*FACET_WIDENING)
    to_rim = rng.random() < FACETS_TO_RIM
    steps = max(4, drawn.segments // (2 * sides))
    form = polygon_form(regular_corners(sides), sides, edge, max(3, round(16 / sides) + 2), steps)
    if not to_rim:
        low = top * drawn.height
        form = rounding(form, rising(low, low + FADE), (low, low + FADE), widening)
    return Shape(form, round_form(drawn.segments))


def flutes(rng: np.random.Generator, drawn: Drawn) -> Shape:
    """Draw flutes cut into the outside of a round inside."""
    count, depth = int(rng.integers(FLUTES[0], FLUTES[1] + 1)), rng.uniform(*FLUTE_DEPTH)
    top = rng.uniform(*FLUTE_TOP) * drawn.height
    weight = everywhere if rng.random() < FLUTES_TO_RIM else falling(top, top + FADE)
    heights = () if weight is everywhere else ((top, top + FADE),)
    plain = Form(round_form(8).xy, _columns(count, drawn.segments, 10), 0, heights)
    return Shape(fluted(plain, count, flute, depth, weight), round_form(drawn.segments))


def ribbed(rng: np.random.Generator, drawn: Drawn) -> Shape:
    """Draw ribs that outside and inside have alike, as mould-blown glass has them."""
    form = ribbed_form(rng, drawn)
    return Shape(form, form)


def ribbed_form(rng: np.random.Generator, drawn: Drawn) -> Form:
    """Draw the form of `ribbed`."""
    count, depth = int(rng.integers(RIBS[0], RIBS[1] + 1)), rng.uniform(*RIB_DEPTH)
    # A wave of height d has crests of radius 2 r^2 / (d count^2): more than the wall, or the inside has an edge.
    depth = min(depth, 2.0 * drawn.largest / (RIB_CREST * drawn.wall * count**2))
    low, high = 0.06 * drawn.height, 0.86 * drawn.height
    up, down = rising(low, low + FADE), falling(high, high + FADE)
    plain = Form(round_form(8).xy, _columns(count, drawn.segments, 12), 0, ((low, low + FADE), (high, high + FADE)))
    return fluted(plain, count, ripple, depth, lambda z: up(z) * down(z))


def square(rng: np.random.Generator, drawn: Drawn) -> Shape:
    """Draw a square, a rectangle, or an ellipse."""
    kind, ratio = rng.random(), rng.uniform(*SIDE_RATIO)
    corner, oval = rng.uniform(*SQUARE_CORNER), rng.uniform(*OVAL_RATIO)
    if kind >= RECTANGLE:
        form = stretched(round_form(drawn.segments), lambda z: np.full_like(z, oval), ())
    else:
        ratio = 1.0 if kind < SQUARE else ratio
        corners = rectangle_corners(ratio)
        steps = max(4, drawn.segments // 4)
        form = polygon_form(corners, 4 if kind < SQUARE else 2, corner, steps, 5)
    return Shape(form, form)


def _columns(count: int, segments: int, least: int) -> tuple[float, ...]:
    """Return columns of which a whole number lies in each of some waves, about `segments` in all."""
    each = max(least, -(-segments // count))
    return tuple((np.arange(each * count) / (each * count)).tolist())
