"""Families of vessels: which sizes and which sequences of pieces make a tumbler, a bottle, a stem glass."""

from __future__ import annotations

import numpy as np

from .containers import (
    angular_bottle_outline,
    jar_outline,
    plastic_bottle_outline,
    plastic_cup_outline,
    vial_outline,
)
from .family_pieces import Family, Proportions, Size, free_chain, free_piece, lip, smoothed
from .laboratory import round_flask_profile, tube_profile, volumetric_flask_outline
from .outline import Outline, bulging, easing, levelling, linear, waved
from .settings import Category
from .tableware import (
    cocktail_outline,
    cup_outline,
    double_walled_outline,
    jug_outline,
    mug_outline,
    teapot_outline,
)

TUMBLER = Proportions(foot=(0.68, 1.0), first=(0.2, 0.8), blend=(0.004, 0.015), bulge=0.08)
BOWL = Proportions(foot=(0.42, 0.65), rim=(0.8, 1.0), first=(0.55, 1.0), blend=(0.004, 0.012), bulge=0.1)
BOTTLE = Proportions(foot=(0.9, 1.0), neck=(0.3, 0.5), first=(0.42, 0.62), second=(0.68, 0.82), bulge=0.05)
STEM_GLASS = Proportions(
    foot=(0.75, 0.95), rim=(0.72, 1.0), first=(0.12, 0.2), second=(0.35, 0.55), blend=(0.004, 0.01), bulge=0.06
)
FLASK = Proportions(foot=(0.5, 0.6), neck=(0.28, 0.42), first=(0.06, 0.12), second=(0.6, 0.72))
VASE = Proportions(
    foot=(0.5, 0.8),
    rim=(1.0, 1.7),
    neck=(0.35, 0.75),
    first=(0.25, 0.5),
    second=(0.65, 0.85),
    blend=(0.008, 0.02),
    bulge=0.1,
)
FREEFORM = Proportions(foot=(0.45, 1.0), first=(0.6, 1.4), blend=(0.004, 0.015), bulge=0.25)

#: Tumbler: most inner knots of the side, and exponents of its taper between straight (1), concave and convex.
_TUMBLER_KNOTS, _TUMBLER_TAPER = 2, (0.6, 1.4)
#: Beaker: width of the flared rim [m], and its height over its width.
_FLARE, _FLARE_HEIGHT = (0.002, 0.004), 2.5
#: Bowl: probability of one continuous curve, and bulge of that, of a quarter of the width that it gains. Steps of less
#: height [m] than this make no rim of their own.
_PLAIN_BOWL, _PLAIN_BULGE, _LEAST_RIM = 0.4, (0.2, 0.8), 0.008
#: Bottle: widest neck [m] (that of a jar is a mouth), probability of a round instead of an S-shaped shoulder.
_WIDEST_NECK, _ROUND_SHOULDER = 0.02, 0.3
#: Stem glass: radius of the stem and thickness of the foot's edge [m]; height of the widest place, of the bowl's; the
#: stem's largest deviation and its radii, of its own radius.
_STEM, _FOOT_EDGE, _BELLY, _STEM_BULGE, _STEM_RADII = (0.0032, 0.0055), (0.0022, 0.0032), (0.45, 0.7), 0.3, (0.8, 1.8)
#: Flask: probability of a conical (Erlenmeyer) instead of a spherical body.
_CONICAL = 0.5
#: Freeform: fewest and most pieces, and smallest radius of the largest.
_PIECES, _LEAST_RADIUS = (2, 5), 0.4
#: Half the heights over which joints are smoothed where they do not vary [m]: beaker, bottle, flask.
_BEAKER_BLEND, _BOTTLE_BLEND, _FLASK_BLEND = 0.003, 0.008, 0.012


def _tumbler(rng: np.random.Generator, size: Size) -> Outline:
    limits = (size.room, size.radius)
    foot = size.radius * rng.uniform(*TUMBLER.foot)
    knots = rng.uniform(*TUMBLER.first, rng.integers(0, _TUMBLER_KNOTS + 1))
    heights = [0.0, *np.sort(knots).tolist(), 1.0]
    radii = [foot + (size.radius - foot) * h ** rng.uniform(*_TUMBLER_TAPER) for h in heights]
    side = free_chain(rng, [h * size.height for h in heights], radii, limits, TUMBLER.bulge)
    return smoothed(side, rng.uniform(*TUMBLER.blend))


def _beaker(rng: np.random.Generator, size: Size) -> Outline:
    flare = rng.uniform(*_FLARE)
    body, start = size.radius - flare, size.height - _FLARE_HEIGHT * flare
    lip = bulging(start, size.height, body, size.radius, bulge=-0.2 * flare, skew=0.0)
    return smoothed((linear(0.0, start, body, body), lip), _BEAKER_BLEND)


def _bowl(rng: np.random.Generator, size: Size) -> Outline:
    foot = max(size.room, size.radius * rng.uniform(*BOWL.foot))
    top = size.height * rng.uniform(*BOWL.first)
    side = levelling(0.0, top, foot, size.radius, power=int(rng.integers(2, 4)))
    if rng.random() < _PLAIN_BOWL or size.height - top < _LEAST_RIM:
        bulge = 0.25 * (size.radius - foot) * rng.uniform(*_PLAIN_BULGE)
        return smoothed((bulging(0.0, size.height, foot, size.radius, bulge=bulge, skew=0.0),), 0.0)
    rim = max(size.room, size.radius * rng.uniform(*BOWL.rim))
    upper = free_chain(rng, [top, size.height], [size.radius, rim], (size.room, size.radius), BOWL.bulge)
    return smoothed((side, *upper), rng.uniform(*BOWL.blend))


def _bottle(rng: np.random.Generator, size: Size) -> Outline:
    height, limits = size.height, (size.room, size.radius)
    neck = max(size.room, min(size.radius * rng.uniform(*BOTTLE.neck), _WIDEST_NECK))
    shoulder, collar = height * rng.uniform(*BOTTLE.first), height * rng.uniform(*BOTTLE.second)
    foot = size.radius * rng.uniform(*BOTTLE.foot)
    body = free_chain(rng, [0.0, shoulder], [foot, size.radius], limits, BOTTLE.bulge)
    slope = easing(shoulder, collar, size.radius, neck)
    if rng.random() < _ROUND_SHOULDER:
        slope = levelling(shoulder, collar, size.radius, neck, power=2)
    start, mouth = lip(rng, height, neck)
    top = (linear(collar, start, neck, neck), linear(start, height, neck, mouth))
    return smoothed((*body, slope, *top), _BOTTLE_BLEND)


def _stem_glass(rng: np.random.Generator, size: Size) -> Outline:
    height, radius = size.height, size.radius
    stem = rng.uniform(*_STEM)
    edge = rng.uniform(*_FOOT_EDGE)
    foot = radius * rng.uniform(*STEM_GLASS.foot)
    flat, start = height * rng.uniform(*STEM_GLASS.first), height * rng.uniform(*STEM_GLASS.second)
    rim = radius * rng.uniform(*STEM_GLASS.rim)
    belly = start + (height - start) * rng.uniform(*_BELLY)
    stem_limits = (_STEM_RADII[0] * stem, _STEM_RADII[1] * stem)
    # The foot falls off steeply (powers 5 to 8), the bowl rounds like a tulip (2 or 3).
    pieces = (
        linear(0.0, edge, foot, foot - 0.2 * edge),
        levelling(edge, flat, foot - 0.2 * edge, stem, power=int(rng.integers(5, 9))),
        free_piece(rng, linear(flat, start, stem, stem), stem_limits, _STEM_BULGE),
        levelling(start, belly, stem, radius, power=int(rng.integers(2, 4))),
        free_piece(rng, linear(belly, height, radius, rim), (0.5 * radius, radius), STEM_GLASS.bulge),
    )
    return smoothed(pieces, rng.uniform(*STEM_GLASS.blend), solid_below=start)


def _flask(rng: np.random.Generator, size: Size) -> Outline:
    height, radius = size.height, size.radius
    neck = max(size.room, radius * rng.uniform(*FLASK.neck))
    collar = height * rng.uniform(*FLASK.second)
    start, mouth = lip(rng, height, neck)
    top = (linear(collar, start, neck, neck), linear(start, height, neck, mouth))
    if rng.random() < _CONICAL:
        belly = height * rng.uniform(*FLASK.first)
        foot = radius - 0.3 * belly
        return smoothed((linear(0.0, belly, foot, radius), linear(belly, collar, radius, neck), *top), _FLASK_BLEND)
    # A spherical body: the arc of a circle is close to a straight line plus half a sine; its top is `radius` wide.
    foot = radius * rng.uniform(*FLASK.foot)
    body = waved(0.0, collar, foot, neck, amplitude=radius - 0.5 * (foot + neck), half_waves=1)
    widest = body.derivative(np.linspace(0.0, collar, 257), 0).max()
    body = waved(0.0, collar, foot, neck, amplitude=body.amplitude - (widest - radius), half_waves=1)
    return smoothed((body, *top), _FLASK_BLEND)


def _vase(rng: np.random.Generator, size: Size) -> Outline:
    height, radius = size.height, size.radius
    belly, neck = height * rng.uniform(*VASE.first), height * rng.uniform(*VASE.second)
    throat = max(size.room, radius * rng.uniform(*VASE.neck))
    foot, rim = radius * rng.uniform(*VASE.foot), min(radius, throat * rng.uniform(*VASE.rim))
    lower = free_piece(rng, linear(0.0, belly, max(size.room, foot), radius), (size.room, radius), VASE.bulge)
    rise = easing(belly, neck, radius, throat)
    mouth = bulging(neck, height, throat, rim, bulge=-0.15 * (rim - throat), skew=0.0)
    return smoothed((lower, rise, mouth), rng.uniform(*VASE.blend))


def _freeform(rng: np.random.Generator, size: Size) -> Outline:
    count = int(rng.integers(_PIECES[0], _PIECES[1] + 1))
    heights = np.concatenate([[0.0], np.cumsum(rng.uniform(*FREEFORM.first, count))])
    radii = size.radius * rng.uniform(*FREEFORM.foot, count + 1)
    radii[rng.integers(count + 1)] = size.radius
    limits = (max(size.room, _LEAST_RADIUS * size.radius), size.radius)
    z = (heights / heights[-1] * size.height).tolist()
    chain = free_chain(rng, z, radii.tolist(), limits, FREEFORM.bulge)
    return smoothed(chain, rng.uniform(*FREEFORM.blend))


#: Sizes are those of common household and laboratory glassware (tumblers 0.1-0.5 l, wine glasses, bottles up to a
#: magnum, laboratory glass from 50 ml), rounded. Of square and oval vessels the radius is half the smaller width, and
#: that of vessels with handles is without them.
FAMILIES: dict[Category, Family] = {
    "tumbler": Family((0.06, 0.17), (0.022, 0.05), (0.24, 0.55), (0.0015, 0.003), (0.003, 0.010), _tumbler),
    "beaker": Family((0.055, 0.19), (0.02, 0.065), (0.33, 0.40), (0.001, 0.0018), (0.002, 0.003), _beaker),
    "bowl": Family((0.04, 0.10), (0.035, 0.08), (0.7, 1.3), (0.0018, 0.004), (0.003, 0.008), _bowl),
    "bottle": Family((0.14, 0.30), (0.025, 0.055), (0.11, 0.24), (0.0018, 0.0035), (0.003, 0.010), _bottle),
    "stem glass": Family((0.11, 0.24), (0.025, 0.05), (0.17, 0.30), (0.001, 0.0016), (0.002, 0.006), _stem_glass),
    "flask": Family((0.09, 0.24), (0.03, 0.075), (0.30, 0.40), (0.001, 0.0022), (0.002, 0.004), _flask),
    "vase": Family((0.10, 0.30), (0.03, 0.075), (0.20, 0.36), (0.002, 0.004), (0.004, 0.010), _vase),
    "freeform": Family((0.04, 0.30), (0.015, 0.08), (0.18, 0.8), (0.001, 0.004), (0.002, 0.010), _freeform),
    # Pressed: Duralex Picardie 90 x 88 mm (25 cl), a Soviet glass of 250 ml 105 x 73 mm, an old-fashioned 90 x 82 mm.
    "faceted glass": Family((0.07, 0.15), (0.03, 0.045), (0.3, 0.5), (0.002, 0.004), (0.004, 0.010), _tumbler),
    "fluted glass": Family((0.07, 0.16), (0.03, 0.045), (0.27, 0.5), (0.0018, 0.0035), (0.004, 0.010), _tumbler),
    # Mould-blown: thinner.
    "ribbed glass": Family((0.07, 0.15), (0.03, 0.045), (0.3, 0.5), (0.0012, 0.0025), (0.003, 0.008), mug_outline),
    "square glass": Family((0.07, 0.14), (0.027, 0.042), (0.28, 0.48), (0.002, 0.004), (0.004, 0.010), mug_outline),
    # Mugs of 0.2 to 0.5 l: 100 x 75 mm to 155 x 95 mm; cups of 0.1 to 0.3 l; jugs of 0.5 to 1.7 l.
    "mug": Family((0.085, 0.16), (0.036, 0.05), (0.3, 0.46), (0.0025, 0.004), (0.004, 0.010), mug_outline),
    "cup": Family((0.05, 0.085), (0.036, 0.055), (0.55, 0.8), (0.0018, 0.0035), (0.003, 0.006), cup_outline),
    "jug": Family((0.15, 0.25), (0.044, 0.066), (0.24, 0.36), (0.002, 0.0035), (0.004, 0.010), jug_outline),
    # Glass teapots of 0.5 to 1.2 l; double-walled glasses of 0.1 to 0.4 l, each wall about 1 mm.
    "teapot": Family((0.085, 0.14), (0.048, 0.07), (0.46, 0.62), (0.0015, 0.0025), (0.002, 0.004), teapot_outline),
    "double-walled glass": Family(
        (0.07, 0.14), (0.034, 0.046), (0.32, 0.5), (0.001, 0.0014), (0.0015, 0.0025), double_walled_outline
    ),
    # Martini glasses and coupes of 0.1 to 0.3 l.
    "cocktail glass": Family(
        (0.13, 0.19), (0.042, 0.06), (0.28, 0.4), (0.001, 0.0018), (0.002, 0.006), cocktail_outline
    ),
    # ISO 3819, low form: 50 ml 42 x 60 mm, 250 ml 70 x 95 mm, 1000 ml 105 x 145 mm.
    "spouted beaker": Family((0.055, 0.15), (0.02, 0.054), (0.34, 0.38), (0.001, 0.0018), (0.002, 0.003), _beaker),
    # ISO 4142 (test tubes): 10 x 75 to 25 x 200 mm, walls of 0.8 to 1.4 mm.
    "test tube": Family((0.075, 0.2), (0.005, 0.0125), (0.05, 0.085), (0.0008, 0.0014), (0.0008, 0.0014), tube_profile),
    # ISO 8362-1: 2R 16 x 35 mm to 100H 52 x 94 mm, walls of 1 to 1.7 mm.
    "vial": Family((0.04, 0.1), (0.01, 0.026), (0.23, 0.32), (0.001, 0.0017), (0.001, 0.0025), vial_outline),
    # ISO 1042: 50 ml 140 mm high to 1000 ml 300 mm.
    "volumetric flask": Family(
        (0.14, 0.3), (0.024, 0.064), (0.17, 0.215), (0.001, 0.002), (0.0015, 0.003), volumetric_flask_outline
    ),
    # ISO 1773: 50 ml 51 x 95 mm to 1000 ml 131 x 210 mm.
    "round flask": Family(
        (0.09, 0.21), (0.025, 0.066), (0.27, 0.32), (0.001, 0.002), (0.001, 0.002), round_flask_profile
    ),
    # Marasca bottles of 250 to 1000 ml (49 x 49 x 192 mm to 74 x 74 x 305 mm); flask bottles of 100 to 500 ml.
    "square bottle": Family(
        (0.14, 0.3), (0.022, 0.038), (0.115, 0.19), (0.002, 0.0035), (0.003, 0.010), angular_bottle_outline
    ),
    "oval bottle": Family(
        (0.12, 0.24), (0.018, 0.03), (0.11, 0.17), (0.002, 0.0035), (0.003, 0.008), angular_bottle_outline
    ),
    # Jars of 100 to 720 ml with twist-off lids.
    "jar": Family((0.07, 0.17), (0.027, 0.05), (0.26, 0.48), (0.0018, 0.0035), (0.003, 0.007), jar_outline),
    # PET bottles of 0.25 to 1 l: walls of 0.25 to 0.4 mm; cups of 0.1 to 0.4 l.
    "plastic bottle": Family(
        (0.15, 0.29), (0.026, 0.042), (0.13, 0.19), (0.0003, 0.0005), (0.0006, 0.0015), plastic_bottle_outline
    ),
    "plastic cup": Family(
        (0.07, 0.13), (0.03, 0.048), (0.34, 0.48), (0.0003, 0.0006), (0.0004, 0.0008), plastic_cup_outline
    ),
}
