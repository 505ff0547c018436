"""Flat prints on tables, drawn at random: sheets, markers, boards, mats, stickers, tape, stains. None is an object."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import get_args

import numpy as np

from ...core.errors import InputError
from ...core.model import Reflectance
from ..description.material import OpaqueMaterial, SurfacePattern
from ..description.surroundings import PrintKind, TablePrint
from ..materials.draw import dielectric, paint_colour
from ..patterns.draw import BLACK_INK, INKS, PAPERS, WOODS, print_colours, surface

PRINT_KINDS: tuple[PrintKind, ...] = get_args(PrintKind)
#: How often each kind is drawn by default. Markers and mats come first: a network takes them for objects.
DEFAULT_PRINTS = ("sheet=2", "newspaper=0.5", "card=1", "markers=2.5", "board=1", "mat=2.5", "sticker", "tape", "stain")
#: Kinds of tables with prints: boards. Cloths hang in folds, and a counter has its sink.
PRINTED_TABLES = ("wood", "stone", "tiles", "laminate", "chequer", "bench", "shelf", "plain")
#: Side of a texel of a print [m], where that needs at most `MOST` of them along a side; fewest along a side [1].
PRINT_TEXEL, MOST, FEWEST = 0.00075, 1024, 8
#: Standard deviation of a print's place from the middle of the table [m]; objects stand within about 0.3 m of it.
SPREAD, NEAR = 0.26, 0.10
#: Distance of prints from the edge of the flat top [m], and places that are tried for one [1].
EDGE, TRIES = 0.004, 60
#: Markers in a group [1], sides of markers with their white [m], and cells across, the border included [1]: families in
#: use have 4 to 6 cells within a border of one.
GROUP, MARKER_SIDE, CELLS = (1, 8), (0.025, 0.13), (6, 9)
#: Probability that a large print lies along the table's sides, and its turn from them then [rad].
ALIGNED, ASKEW = 0.6, 0.06

Sizes = Sequence[tuple[float, float]]
#: Paper [m]: ISO 216 A5, A4, A3, and US letter.
SHEETS: Sizes = ((0.148, 0.210), (0.210, 0.297), (0.210, 0.297), (0.297, 0.420), (0.216, 0.279))
#: Newspapers, a page and open [m]: tabloid 280 x 430 mm, Berliner 315 x 470 mm (in the trade).
NEWSPAPERS: Sizes = ((0.280, 0.430), (0.315, 0.470), (0.560, 0.430), (0.630, 0.470))
#: Postcards (A6), photographs, magazines, posters (A3, A2) [m].
CARDS: Sizes = ((0.105, 0.148), (0.100, 0.150), (0.130, 0.180), (0.210, 0.280), (0.297, 0.420), (0.420, 0.594))
#: Calibration boards [m]: A5 to A2, and square ones.
BOARDS: Sizes = ((0.148, 0.210), (0.210, 0.297), (0.297, 0.420), (0.420, 0.594), (0.20, 0.20), (0.30, 0.30))
#: Cutting mats A4, A3, A2 [m], as sold: with their rims larger than the paper.
CUTTING_MATS: Sizes = ((0.30, 0.22), (0.45, 0.30), (0.60, 0.45))
#: Place mats, sold as 450 x 300 to 480 x 330 mm, smaller ones of 350 x 250 mm, and desk pads [m].
PLACE_MATS: Sizes = ((0.45, 0.30), (0.48, 0.33), (0.35, 0.25), (0.40, 0.40), (0.60, 0.40))
#: Sides of stickers, lengths of tape, and sizes of stains [m]; widths of tape in the trade [m].
STICKER, TAPE, STAIN = (0.015, 0.08), (0.05, 0.6), (0.04, 0.14)
TAPE_WIDTHS = (0.012, 0.019, 0.025, 0.038, 0.048)
#: Grounds of cutting mats, rubber, tapes, and what is spilt (coffee, tea, wine, water marks), linear Rec.709, by eye.
_CUTTING: tuple[Reflectance, ...] = (
    (0.02, 0.12, 0.07),
    (0.03, 0.09, 0.20),
    (0.05, 0.05, 0.055),
    (0.20, 0.20, 0.20),
    (0.35, 0.10, 0.14),
)
_RUBBER: tuple[Reflectance, ...] = ((0.02, 0.02, 0.022), (0.06, 0.06, 0.065), (0.16, 0.16, 0.16), (0.16, 0.05, 0.04))
_TAPES: tuple[Reflectance, ...] = (
    (0.62, 0.52, 0.34),
    (0.03, 0.13, 0.38),
    (0.02, 0.02, 0.02),
    (0.60, 0.42, 0.02),
    (0.38, 0.38, 0.38),
    (0.72, 0.71, 0.69),
    (0.42, 0.03, 0.02),
    (0.36, 0.24, 0.12),
)
_SPILT: tuple[Reflectance, ...] = ((0.06, 0.03, 0.015), (0.20, 0.10, 0.03), (0.10, 0.02, 0.03), (0.45, 0.43, 0.40))
#: Range of the roughness of paper, of coated paper, and of vinyl and laminated print [1].
PAPER, COATED, VINYL = (0.6, 0.95), (0.3, 0.6), (0.25, 0.6)


@dataclass(frozen=True)
class _Look:
    """What a print is before it has a place."""

    size: tuple[float, float]
    material: OpaqueMaterial


Draw = Callable[[np.random.Generator, float], _Look]


def draw_prints(
    rng: np.random.Generator, kinds: Mapping[str, float], count: int, outline: np.ndarray, wear: float
) -> tuple[TablePrint, ...]:
    """Draw the prints on a table: whole on its flat top, mats below sheets, sheets below markers.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of all draws.
    kinds : mapping of str to float
        Weights of kinds. One that finds no place on the table is not drawn on it.
    count : int
        How many are drawn; a group of markers counts as one.
    outline : (k, 2) float
        Convex outline of the flat top, counter-clockwise [m].
    wear : float
        0 new, 1 worn; of what is no paper.

    Raises
    ------
    InputError
        Where none of the kinds finds a place on the table.
    """
    left: dict[PrintKind, float] = {kind: kinds[kind] for kind in PRINT_KINDS if kind in kinds}
    found: list[TablePrint] = []
    for _ in range(count):
        found += _some(rng, left, outline, wear)
    return tuple(sorted(found, key=lambda item: _LAYERS.index(item.kind)))


def _some(rng: np.random.Generator, left: dict[PrintKind, float], outline: np.ndarray, wear: float) -> list[TablePrint]:
    """Return a print, or a group of markers; kinds that find no place are taken out of those that are left."""
    while True:
        names, weights = list(left), np.array([*left.values()])
        kind = names[int(rng.choice(len(names), p=weights / weights.sum()))]
        looks = _markers(rng) if kind == "markers" else [_DRAWN[kind]]
        placed = [_placed(rng, kind, look, outline, wear) for look in looks]
        if all(placed):
            return [item for item in placed if item is not None]
        if len(left) == 1:
            (length, width), size = np.ptp(outline, axis=0), looks[0](rng, wear).size
            expected = f"prints that have a place on the flat top of {length:.2f} x {width:.2f} m"
            raise InputError("table.print_kinds", expected, f"{kind}, such as one of {size[0]:.2f} x {size[1]:.2f} m")
        del left[kind]


def _placed(
    rng: np.random.Generator, kind: PrintKind, look: Draw, outline: np.ndarray, wear: float
) -> TablePrint | None:
    """Return a print at a place where all of it lies on the top, or None where none of those tried is one."""
    for _ in range(TRIES):
        drawn = look(rng, wear)
        angle = rng.uniform(-np.pi, np.pi)
        if min(drawn.size) > 0.1 and rng.random() < ALIGNED:
            angle = float(rng.integers(4)) * np.pi / 2 + rng.normal(0.0, ASKEW)
        x, y = rng.normal(0.0, NEAR if kind == "mat" else SPREAD, 2)
        item = TablePrint(
            kind=kind, centre=(float(x), float(y)), angle=float(angle), size=drawn.size, material=drawn.material
        )
        if lies_on(item, outline, EDGE):
            return item
    return None


def lies_on(item: TablePrint, outline: np.ndarray, edge: float = 0.0) -> bool:
    """Return whether a print is within a convex outline, (k, 2) counter-clockwise [m], and `edge` [m] away from it."""
    sides = np.roll(outline, -1, axis=0) - outline
    inwards = np.stack([-sides[:, 1], sides[:, 0]], 1) / np.linalg.norm(sides, axis=1, keepdims=True)
    return bool((((item.corners[:, None] - outline) * inwards).sum(axis=2) >= edge).all())


def _look(
    rng: np.random.Generator,
    name: str,
    pattern: SurfacePattern,
    colours: Sequence[Reflectance],
    size: tuple[float, float],
    roughness: tuple[float, float],
    wear: float,
    layout: tuple[float, ...] = (),
) -> _Look:
    """Return a print of a pattern over its whole size."""
    texels = tuple(int(np.clip(round(side / PRINT_TEXEL), FEWEST, MOST)) for side in size)
    made = surface(
        rng,
        name,
        pattern,
        colours,
        size,
        roughness,
        size=(texels[0], texels[1]),
        wear=wear,
        layout=layout,
        atlas=True,
    )
    return _Look(size, made)


def _of_sizes(rng: np.random.Generator, sizes: Sizes) -> tuple[float, float]:
    """Return one of some sizes, either way round."""
    width, height = sizes[int(rng.integers(len(sizes)))]
    return (width, height) if rng.random() < 0.5 else (height, width)


def _paper(rng: np.random.Generator) -> Reflectance:
    return dielectric(np.array(PAPERS[int(rng.integers(len(PAPERS)))]) * rng.uniform(0.9, 1.05))


def _sheet(rng: np.random.Generator, wear: float) -> _Look:
    del wear  # what is of paper shows no scratches, and is thrown away before it is worn
    inks = [INKS[index] for index in rng.permutation(len(INKS))[:2]]
    colours = (_paper(rng), *inks, BLACK_INK)
    return _look(rng, "printed paper", "printed sheet", colours, _of_sizes(rng, SHEETS), PAPER, 0.0)


def _newspaper(rng: np.random.Generator, wear: float) -> _Look:
    del wear
    paper = dielectric(np.array((0.52, 0.49, 0.43)) * rng.uniform(0.85, 1.1))
    inks = [INKS[index] for index in rng.permutation(len(INKS))[:2]]
    size = NEWSPAPERS[int(rng.integers(len(NEWSPAPERS)))]
    return _look(rng, "newsprint", "newspaper", (paper, *inks, BLACK_INK), size, (0.8, 1.0), 0.0)


def _card(rng: np.random.Generator, wear: float) -> _Look:
    del wear
    return _look(rng, "coated paper", "card", print_colours(rng), _of_sizes(rng, CARDS), COATED, 0.0)


def _board(rng: np.random.Generator, wear: float) -> _Look:
    del wear
    name, roughness = ("laminated paper", VINYL) if rng.random() < 0.4 else ("printed paper", PAPER)
    colours = (_paper(rng), BLACK_INK)
    return _look(rng, name, "marker board", colours, _of_sizes(rng, BOARDS), roughness, 0.0)


def _markers(rng: np.random.Generator) -> list[Draw]:
    """Return a group of markers of one size and family, each with cells of its own."""
    low, high = np.log(MARKER_SIDE)
    side, cells = float(np.exp(rng.uniform(low, high))), float(rng.integers(*CELLS))
    colours, count = (_paper(rng), BLACK_INK), int(rng.integers(GROUP[0], GROUP[1] + 1))

    def look(rng: np.random.Generator, wear: float) -> _Look:
        del wear
        return _look(rng, "printed paper", "marker", colours, (side, side), PAPER, 0.0, (cells,))

    return [look] * count


def _mat(rng: np.random.Generator, wear: float) -> _Look:
    kind = int(rng.choice(5, p=(0.3, 0.25, 0.15, 0.2, 0.1)))
    if kind == 0:
        ground = dielectric(np.array(_CUTTING[int(rng.integers(len(_CUTTING)))]) * rng.uniform(0.8, 1.3))
        lines = dielectric(np.array((0.62, 0.60, 0.45)) * rng.uniform(0.6, 1.1))
        return _look(rng, "vinyl", "cutting mat", (ground, lines), _of_sizes(rng, CUTTING_MATS), VINYL, wear)
    size = _of_sizes(rng, PLACE_MATS)
    if kind == 1:
        colours = [paint_colour(rng) for _ in range(3)]
        return _look(rng, "vinyl", "place mat", colours, size, VINYL, wear)
    if kind == 2:
        colour = dielectric(np.array(_RUBBER[int(rng.integers(len(_RUBBER)))]) * rng.uniform(0.8, 1.4))
        return _look(rng, "rubber", "ribbed rubber", [colour], size, (0.6, 0.95), wear)
    if kind == 3:
        pattern: SurfacePattern = ("cloth", "checked cloth", "striped cloth")[int(rng.integers(3))]
        return _look(rng, "cotton", pattern, (paint_colour(rng), paint_colour(rng)), size, (0.85, 1.0), wear)
    wood = tuple(WOODS)[int(rng.integers(len(WOODS)))]
    return _look(rng, "bamboo", "staves", WOODS[wood], size, (0.4, 0.7), wear)


def _sticker(rng: np.random.Generator, wear: float) -> _Look:
    width = float(np.exp(rng.uniform(*np.log(STICKER))))
    size = (width, width * float(rng.choice((1.0, 1.0, 0.6, 0.4))))
    return _look(rng, "vinyl", "sticker", print_colours(rng), size, VINYL, wear)


def _tape(rng: np.random.Generator, wear: float) -> _Look:
    size = (float(np.exp(rng.uniform(*np.log(TAPE)))), float(rng.choice(TAPE_WIDTHS)))
    first, second = rng.permutation(len(_TAPES))[:2]
    return _look(rng, "tape", "tape", (_TAPES[first], _TAPES[second]), size, VINYL, wear)


def _stain(rng: np.random.Generator, wear: float) -> _Look:
    width = rng.uniform(*STAIN)
    size = (float(width), float(width * rng.uniform(0.7, 1.0)))
    return _look(rng, "stain", "stain", [_SPILT[int(rng.integers(len(_SPILT)))]], size, (0.2, 0.6), wear)


_DRAWN: dict[PrintKind, Draw] = {
    "sheet": _sheet,
    "newspaper": _newspaper,
    "card": _card,
    "board": _board,
    "mat": _mat,
    "sticker": _sticker,
    "tape": _tape,
    "stain": _stain,
}
#: Kinds from what lies lowest to what lies above all.
_LAYERS: tuple[PrintKind, ...] = (
    "mat",
    "newspaper",
    "card",
    "board",
    "sheet",
    "markers",
    "tape",
    "sticker",
    "stain",
)
