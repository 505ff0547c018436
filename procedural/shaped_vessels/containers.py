"""Bottles with square and oval bodies, plastic bottles and cups, beakers with a spout."""

from __future__ import annotations

import numpy as np

from .forms import Form, denser, lipped, polygon_form, rectangle_corners, rising, round_form, rounding, stretched
from .handled import LIP_COLUMNS, LIP_COVER
from .shapes import Drawn, Shape
from .tumblers import ribbed_form

#: Radius of the corners of square bottles over half their width; ratio of sides of rectangular ones, and their share.
CORNER, RATIO, RECTANGULAR = (0.2, 0.5), (1.2, 1.6), 0.3
#: Ratio of the widths of oval bottles (flask bottles of 200 ml are 75 x 37 mm).
OVAL_RATIO = (1.4, 2.0)
#: Spout of a beaker (ISO 3819 asks for one that pours without running down): how far it stands out, of the radius; its
#: width [rad]; where it begins, of the height.
SPOUT, SPOUT_WIDTH, SPOUT_LOW = (0.1, 0.2), (0.2, 0.32), (0.84, 0.92)
#: Share of plastic cups with vertical ribs.
RIBBED_CUPS = 0.5


def square_bottle(rng: np.random.Generator, drawn: Drawn) -> Shape:
    """Draw a square or rectangular body under a round neck."""
    corner, ratio = rng.uniform(*CORNER), rng.uniform(*RATIO)
    rectangular = rng.random() < RECTANGULAR
    corners = rectangle_corners(ratio if rectangular else 1.0)
    form = polygon_form(corners, 2 if rectangular else 4, corner, max(8, drawn.segments // 8), 8)
    low, high = _shoulder(drawn)
    form = rounding(form, rising(low, high), (low, high))
    return Shape(form, form)


def oval_bottle(rng: np.random.Generator, drawn: Drawn) -> Shape:
    """Draw an oval body under a round neck."""
    ratio, (low, high) = rng.uniform(*OVAL_RATIO), _shoulder(drawn)
    weight = rising(low, high)
    form = stretched(round_form(_columns(drawn, ratio)), lambda z: ratio + (1.0 - ratio) * weight(z), ((low, high),))
    return Shape(form, form)


def spouted_beaker(rng: np.random.Generator, drawn: Drawn) -> Shape:
    """Draw a pouring spout at +x."""
    low, width = rng.uniform(*SPOUT_LOW) * drawn.height, rng.uniform(*SPOUT_WIDTH)
    form = lipped(round_form(drawn.segments), rng.uniform(*SPOUT) * drawn.largest, width, low, drawn.height)
    form = denser(form, LIP_COVER * width, LIP_COLUMNS)
    return Shape(form, form)


def plain(rng: np.random.Generator, drawn: Drawn) -> Shape:
    """Return a round cross-section."""
    form = round_form(drawn.segments)
    return Shape(form, form)


def plastic_cup(rng: np.random.Generator, drawn: Drawn) -> Shape:
    """Draw a cup with or without vertical ribs."""
    form: Form = ribbed_form(rng, drawn) if rng.random() < RIBBED_CUPS else round_form(drawn.segments)
    return Shape(form, form)


def _shoulder(drawn: Drawn) -> tuple[float, float]:
    """Return the heights between which the body turns into the neck [m]: the outline's second piece."""
    return drawn.outline.pieces[1].low, drawn.outline.pieces[1].high


def _columns(drawn: Drawn, ratio: float) -> int:
    return 8 * int(np.ceil(drawn.segments * np.sqrt(ratio) / 8.0))
