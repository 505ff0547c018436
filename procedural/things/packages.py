"""Books, cartons and cans, with print on them."""

from __future__ import annotations

import numpy as np

from ...core.mesh import Mesh
from ..patterns.draw import PAPERS, metal, plain, print_colours, surface
from ..props.blocks import rounded_box
from ..props.revolution import Piece, rounded
from .parts import Part, Thing, some
from .solids import faces_of_pieces, finished, moved, projected, rotation, slab, turned

#: Formats of books, width and height [m]: pocket (A), B and trade paperbacks, A5, demy and royal octavo, as the trade
#: has them; a copy is up to 2 % off.
FORMATS = ((0.110, 0.178), (0.129, 0.198), (0.135, 0.216), (0.148, 0.210), (0.138, 0.216), (0.156, 0.234))
FORMAT_SPREAD = 0.02
#: Thickness of the leaves together [m]: 150 to 700 pages of 0.1 mm a leaf, 80 g/m^2.
LEAVES = (0.009, 0.034)
#: Thickness of a hard cover's boards and of a paperback's card [m], and how far boards stand over the leaves [m].
BOARD, CARD, SQUARES = 0.0025, 0.0004, 0.003
#: Heights of cartons [m] (medicine 0.07, tea 0.08, biscuits and pasta up to 0.2), their width over the height, their
#: depth over the height, and the radius of their folds [m].
CARTON_HEIGHT, CARTON_WIDTH, CARTON_DEPTH, FOLD = (0.07, 0.20), (0.45, 0.85), (0.22, 0.5), (0.0005, 0.0012)
#: Food cans: diameter and height [m] of the sizes of 425 ml, 212 ml, 850 ml and flat fish cans.
FOOD_CANS = ((0.073, 0.110), (0.073, 0.058), (0.099, 0.118), (0.083, 0.038))
#: Drink cans: diameter and height [m] of the standard 330 ml, sleek 330 ml and slim 250 ml.
DRINK_CANS = ((0.0662, 0.1152), (0.0574, 0.1450), (0.0533, 0.1337))
#: Height and width of the double seam of a can [m].
SEAM_HEIGHT, SEAM_WIDTH = 0.003, 0.0013


def book(rng: np.random.Generator, wear: float) -> Thing:
    """Return a book, lying with its front up: a cover of one piece around the back, and the leaves."""
    width, height = np.array(FORMATS[rng.integers(len(FORMATS))]) * rng.uniform(1 - FORMAT_SPREAD, 1 + FORMAT_SPREAD)
    leaves, hard = rng.uniform(*LEAVES), rng.random() < 0.5
    board, over = (BOARD, SQUARES) if hard else (CARD, 0.0)
    thick = leaves + 2 * board
    bulge = rng.uniform(0.08, 0.2) * thick if hard else 0.0
    outline, outer = _cover_outline(width, thick, board, bulge, groove=0.0009 if hard else 0.0)
    lengths = np.linalg.norm(np.diff(outline[: outer + 1], axis=0), axis=1)
    total = float(lengths.sum())
    mesh, outside = _bent(outline, outer, height, total)
    colours = print_colours(rng)
    roughness = (0.25, 0.45) if rng.random() < 0.5 else (0.5, 0.75)
    spine = (total - 2 * (width - 0.0)) / total
    print_ = surface(
        rng,
        "printed cloth-bound board" if hard else "printed card",
        "cover",
        colours,
        (total, float(height)),
        roughness,
        size=(512, 384),
        wear=wear,
        layout=(max(0.02, spine),),
    )
    lining = plain(rng, "lining paper", PAPERS[rng.integers(len(PAPERS))], (0.6, 0.9))
    paper = surface(
        rng,
        "paper",
        "page edges",
        [(0.52, 0.46, 0.36), (0.80, 0.76, 0.66)] if rng.random() < 0.5 else [(0.58, 0.56, 0.52), (0.82, 0.81, 0.78)],
        (0.2, float(leaves)),
        (0.7, 0.9),
        size=(128, 128),
        wear=wear,
    )
    # Of a paperback they are cut with the cover, a hair inside it here, so that no edge belongs to both.
    inset = max(over, 0.0002)
    block = _leaves(width - inset, height - 2 * inset, leaves, board, (0.06 if hard else 0.012) * thick)
    return Thing(
        (
            Part("cover", some(mesh, outside), print_),
            Part("inside of the cover", projected(some(mesh, ~outside)), lining),
            Part("leaves", block, paper),
        )
    )


def _cover_outline(width: float, thick: float, board: float, bulge: float, groove: float) -> tuple[np.ndarray, int]:
    """Return a cover's section (x, z), counter-clockwise from the front's fore edge, and how many edges are outside."""
    bend = np.linspace(1.0, -1.0, 13)
    back = np.stack([-bulge * (1 - bend**2), thick / 2 + bend * thick / 2], 1)
    if groove:
        joint = np.array([[0.011, 0.0], [0.008, -groove], [0.005, -groove], [0.002, 0.0]])
        front = np.concatenate([[[width, thick]], joint + np.array([0.0, thick]), back])
        outside = np.concatenate([front, joint[::-1] * [1, -1], [[width, 0.0]]])
    else:
        outside = np.concatenate([[[width, thick]], back, [[width, 0.0]]])
    inside_back = np.stack([board - bulge * (1 - bend[::-1] ** 2), thick / 2 + bend[::-1] * (thick / 2 - board)], 1)
    inside = np.concatenate([[[width, board]], inside_back, [[width, thick - board]]])
    return np.concatenate([outside, inside]), len(outside) - 1


def _bent(outline: np.ndarray, outer: int, height: float, total: float) -> tuple[Mesh, np.ndarray]:
    """Return a cover over its section, and which of its faces are its outside; u and v lie on the opened cover [m]."""
    import manifold3d

    count = len(outline)
    ring = np.concatenate([outline, outline[:1]])
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1))])
    rows = [np.column_stack([ring, np.full(count + 1, z)]) for z in (-height / 2, height / 2)]
    coordinates = [np.stack([total - along, np.full(count + 1, v)], 1) for v in (height, 0.0)]
    i = np.arange(count)
    first = np.stack([i, i + 1, i + 1 + count + 1], 1), np.stack([i, i + 1 + count + 1, i + count + 1], 1)
    cap = np.asarray(manifold3d.triangulate([outline]), np.int64)
    faces = np.concatenate([*first, cap[:, ::-1], cap + count + 1])
    segment = np.concatenate([i, i, np.full(2 * len(cap), count)])
    mesh = finished(np.concatenate(rows), faces, np.concatenate(coordinates), crease=np.radians(50.0))
    return moved(mesh, turn=rotation(0, np.pi / 2)), segment < outer


def _leaves(width: float, height: float, leaves: float, board: float, hollow: float) -> Mesh:
    """Return the block of leaves, whose fore edge is hollow by as much as the back is round."""
    bend = np.linspace(-1.0, 1.0, 9)
    fore = np.stack([width - hollow * (1 - bend**2), board + leaves * (bend + 1) / 2], 1)
    gap = 0.0008
    outline = np.concatenate([[[board + gap, board]], fore, [[board + gap, board + leaves]]])
    mesh = slab([outline], height)
    return projected(moved(mesh, turn=rotation(0, np.pi / 2)))


def carton(rng: np.random.Generator, wear: float) -> Thing:
    """Return a folding carton, standing, printed on all sides."""
    high = float(np.exp(rng.uniform(*np.log(CARTON_HEIGHT))))
    wide, deep = high * rng.uniform(*CARTON_WIDTH), high * rng.uniform(*CARTON_DEPTH)
    if rng.random() < 0.3:  # a flat one, such as of medicine, lies on its back more often than not
        deep *= 0.6
    mesh, unit = rounded_box("part", (wide, deep, high), rng.uniform(*FOLD))
    assert mesh.uv is not None
    uv = _unfolded(mesh.uv * unit, wide, deep, high)
    extent = (2 * (wide + deep), high + deep)
    print_ = surface(
        rng,
        "printed carton",
        "carton",
        print_colours(rng),
        extent,
        (0.3, 0.65),
        size=(512, int(np.clip(round(512 * extent[1] / extent[0] / 16) * 16, 128, 512))),
        wear=wear,
        layout=(deep / high,),
    )
    return Thing((Part("carton", Mesh("part", mesh.vertices, mesh.faces, mesh.normals, uv), print_),))


def _unfolded(uv: np.ndarray, wide: float, deep: float, high: float) -> np.ndarray:
    """Return the places of a rounded box's six faces on the unfolded carton [m].

    The faces come as `blocks.rounded_box` has them, +x -x +y -y +z -z, with coordinates from their middles.
    """
    faces = uv.reshape(6, -1, 2)
    swapped = np.stack([-faces[..., 1], faces[..., 0]], -1)
    placed = np.empty_like(faces)
    middles = (
        (wide + deep / 2, high / 2),
        (2 * wide + 1.5 * deep, high / 2),
        (1.5 * wide + deep, high / 2),
        (wide / 2, high / 2),
        (wide / 2, high + deep / 2),
        (wide / 2, high + deep / 2),
    )
    for face, middle in enumerate(middles):
        placed[face] = (swapped if face in (1, 2, 5) else faces)[face] + middle
    return placed.reshape(-1, 2)


def can(rng: np.random.Generator, wear: float) -> Thing:
    """Return a food can with a paper label or a printed drink can, standing."""
    return _food_can(rng, wear) if rng.random() < 0.6 else _drink_can(rng, wear)


def _food_can(rng: np.random.Generator, wear: float) -> Thing:
    diameter, height = FOOD_CANS[rng.integers(len(FOOD_CANS))]
    radius, seam = diameter / 2 - SEAM_WIDTH, SEAM_HEIGHT
    inside = radius - 0.0012
    depth = 0.0042
    # Countersunk ends with a bead, a body behind the seams.
    rings = [(0.0, depth), (0.45 * inside, depth), (0.5 * inside, depth - 0.0012), (0.72 * inside, depth - 0.0012)]
    rings += [(0.77 * inside, depth), (inside, depth), (inside, 0.0)]
    low = [*rings, (radius + SEAM_WIDTH, 0.0), (radius + SEAM_WIDTH, seam), (radius, seam + 0.0004)]
    corners = low + [(r, height - z) for r, z in reversed(low)]
    small = [0.0] * (len(corners) - 2)
    for place in (5, 6, 7):  # the seam is rolled
        small[place] = small[-1 - place] = 0.0006
    pieces = rounded(corners, small)
    return _labelled(rng, wear, pieces, radius, "tinplate", "paper label", (0.35, 0.7))


def _drink_can(rng: np.random.Generator, wear: float) -> Thing:
    diameter, height = DRINK_CANS[rng.integers(len(DRINK_CANS))]
    radius, neck = diameter / 2, diameter / 2 - 0.0065
    foot = radius - 0.009
    corners = [(0.0, 0.010), (0.55 * foot, 0.0075), (foot - 0.0015, 0.0), (foot + 0.0015, 0.0), (radius, 0.0095)]
    corners += [(radius, height - 0.017), (neck, height - 0.003), (neck + 0.0012, height - 0.0028)]
    corners += [
        (neck + 0.0012, height),
        (neck - 0.0012, height),
        (neck - 0.003, height - 0.0065),
        (0.0, height - 0.0065),
    ]
    radii = [0.006, 0.0012, 0.0012, 0.005, 0.008, 0.0001, 0.0002, 0.0006, 0.0006, 0.0015]
    thing = _labelled(rng, wear, rounded(corners, radii), radius, "aluminium", "printed aluminium", (0.2, 0.35))
    tab = slab(
        [np.array([[0.0045, 0.0]]) + _oval(0.012, 0.0075), (_oval(0.0045, 0.0045) + np.array([0.0105, 0.0]))[::-1]],
        0.0009,
    )
    return Thing(
        (*thing.parts, Part("tab", moved(tab, (0.0, 0.0, height - 0.0052)), metal(rng, wear, "aluminium", 0.0)))
    )


def _oval(half_x: float, half_y: float) -> np.ndarray:
    turn = 2 * np.pi * np.arange(24) / 24
    return np.stack([half_x * np.cos(turn), half_y * np.sin(turn)], 1)


def _labelled(
    rng: np.random.Generator,
    wear: float,
    pieces: list[Piece],
    radius: float,
    kind: str,
    label: str,
    roughness: tuple[float, float],
) -> Thing:
    """Return a can whose side, the longest piece of its profile, is printed."""
    mesh = turned(pieces)
    assert mesh.uv is not None
    lengths = [float(np.linalg.norm(np.diff(piece.points, axis=0), axis=1).sum()) for piece in pieces]
    upright = [length * (piece.points[0, 0] > 0.99 * radius) for length, piece in zip(lengths, pieces, strict=True)]
    side = faces_of_pieces(mesh, pieces) == int(np.argmax(upright))
    printed = some(mesh, side)
    assert printed.uv is not None
    around, height = 2 * np.pi * radius, float(np.ptp(printed.bounds[:, 2]))
    # Once around whatever the seam's radius, and from the label's lower edge up.
    u = printed.uv[:, 0] / printed.uv[:, 0].max() * around
    uv = np.stack([u, printed.vertices[:, 2] - printed.bounds[0, 2]], 1)
    paper = surface(
        rng,
        label,
        "label",
        print_colours(rng),
        (float(around), height),
        roughness,
        size=(512, int(np.clip(round(512 * height / around / 16) * 16, 64, 512))),
        wear=wear,
    )
    bare = metal(rng, wear, {"tinplate": "steel"}.get(kind, kind), 0.3)
    return Thing(
        (
            Part("label", Mesh("part", printed.vertices, printed.faces, printed.normals, uv), paper),
            Part("metal", some(mesh, ~side, planar=True), bare.model_copy(update={"name": kind})),
        )
    )
