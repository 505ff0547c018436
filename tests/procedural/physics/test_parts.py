"""Convex parts contain the body that they stand for, and little more."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from glassware.core.mesh import Mesh, volume_of
from glassware.core.randomness import stream
from glassware.procedural.description.bodies import Prop
from glassware.procedural.description.material import OpaqueMaterial, UniformTexture
from glassware.procedural.physics.parts import body_parts, with_attached
from glassware.procedural.physics.sections import area, coarser, convex_pieces, hull
from glassware.procedural.physics.sectors import SIMPLIFICATION
from glassware.procedural.physics.thin import LEAST_THICKNESS, thickened
from glassware.procedural.physics.wedges import WEDGE_TOLERANCE, ConvexPart, revolved_hull, revolved_parts
from glassware.procedural.props.draw import PropSettings
from glassware.procedural.things.draw import draw_prop_of_kind

#: Half section of a thick cup [m]: 40 mm wide and 80 mm high inside walls of 3 mm.
CUP = np.array([[0.0, 0.0], [0.043, 0.0], [0.043, 0.083], [0.040, 0.083], [0.040, 0.003], [0.0, 0.003]])
ROUNDING = 1e-9


def _bowl(radius: float = 0.05, wall: float = 0.002) -> np.ndarray:
    angles = np.linspace(-0.5 * np.pi, 0.0, 60)
    circle = np.stack([np.cos(angles), np.sin(angles)], 1)
    circle[0, 0] = 0.0
    return np.concatenate([radius * circle, (radius - wall) * circle[::-1]])


def _inside(part: ConvexPart, points: np.ndarray, reach: float = ROUNDING) -> np.ndarray:
    planes, found = ConvexHull(part.points).equations, np.zeros(len(points), dtype=bool)
    for turn in 2.0 * np.pi * np.arange(part.turns) / part.turns:
        back = np.array([[np.cos(turn), np.sin(turn), 0.0], [-np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]])
        found |= (points @ back.T @ planes[:, :3].T + planes[:, 3]).max(1) <= reach
    return found


@pytest.mark.parametrize("outline", [CUP, _bowl()], ids=["cup", "bowl"])
def test_pieces_of_a_section_are_convex_and_cover_it(outline):
    pieces = convex_pieces(outline, 2e-4)
    whole, covered = area(outline), sum(area(piece) for piece in pieces)
    assert whole <= covered + ROUNDING
    assert covered < 1.1 * whole
    assert all(len(hull(piece)) == len(piece) for piece in pieces)


@pytest.mark.parametrize("outline", [CUP, _bowl()], ids=["cup", "bowl"])
def test_wedges_contain_the_wall_and_leave_the_inside_free(outline):
    rng = np.random.default_rng(1)
    parts = revolved_parts(outline)
    low, high = outline.min(0), outline.max(0)
    sample = rng.uniform(low, high, (6000, 2))
    angle = rng.uniform(0.0, 2.0 * np.pi, len(sample))
    points = np.column_stack([sample[:, 0] * np.cos(angle), sample[:, 0] * np.sin(angle), sample[:, 1]])
    within = np.any([_inside(part, points) for part in parts], axis=0)
    depth = _signed_depth(outline, sample)
    assert within[depth > 1e-6].all()
    assert not within[depth < -3.0 * WEDGE_TOLERANCE].any()


def _signed_depth(outline: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Distance of points to the outline, positive inside [m]."""
    from matplotlib.path import Path

    start, end = outline, np.roll(outline, -1, axis=0)
    along = end - start
    offset = points[:, None] - start
    part = np.clip((offset * along).sum(2) / np.maximum((along**2).sum(1), 1e-30), 0.0, 1.0)
    away = np.linalg.norm(offset - part[..., None] * along, axis=2)
    # The section's border on the axis is no surface.
    away[:, (start[:, 0] == 0.0) & (end[:, 0] == 0.0)] = np.inf
    return np.where(Path(outline).contains_points(points), 1.0, -1.0) * away.min(1)


def test_a_coarser_polygon_contains_the_first_and_is_near_it():
    angles = np.linspace(0.0, 2.0 * np.pi, 101)[:-1]
    circle = np.stack([0.1 + 0.05 * np.cos(angles), 0.05 * np.sin(angles)], 1)
    found = coarser(circle, 1e-4)
    assert len(found) < 70
    assert area(hull(np.concatenate([circle, found]))) == pytest.approx(area(found), rel=1e-6)
    assert np.hypot(*(found - (0.1, 0.0)).T).max() < 0.05 + 3e-4


def test_the_hull_of_a_solid_of_revolution_contains_it():
    corners = revolved_hull(CUP)
    planes = ConvexHull(corners).equations
    angles = np.linspace(0.0, 2.0 * np.pi, 200)
    rim = np.stack([0.043 * np.cos(angles), 0.043 * np.sin(angles), np.full(200, 0.083)], 1)
    assert (rim @ planes[:, :3].T + planes[:, 3]).max() <= ROUNDING
    assert np.hypot(*corners[:, :2].T).max() < 0.0432


def _prop(name: str, points: np.ndarray, **more: object) -> Prop:
    hull = ConvexHull(points, qhull_options="QJ")
    mesh = Mesh(name, points.astype(np.float32), hull.simplices)
    paper = OpaqueMaterial(name="paper", base_colour=UniformTexture(colour=(0.7, 0.7, 0.7)), roughness=0.6)
    size = tuple(np.ptp(points, axis=0).tolist())
    common = {"id": 2, "name": name, "category": "sheet", "mesh": mesh, "material": paper, "size": size}
    return Prop.model_validate({**common, "symmetric": False, "world_T_object": np.eye(4), **more})


def _box(*size: float) -> np.ndarray:
    corners = np.stack(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5], indexing="ij"), -1).reshape(-1, 3)
    return corners * size


@pytest.mark.parametrize("size", [(0.1, 0.2, 0.0), (0.1, 0.0, 0.0), (0.1, 0.2, 1e-6), (0.0, 0.0, 0.0)])
def test_thin_parts_get_the_least_thickness_about_where_they_are(size):
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    points = _box(*size) @ turn.T + (0.02, -0.05, 0.1)
    found = (thickened(points) - (0.02, -0.05, 0.1)) @ turn
    extent = np.ptp(found, axis=0)
    np.testing.assert_allclose(extent[np.array(size) > 1e-3], [side for side in size if side > 1e-3], atol=1e-8)
    # A strip's section may be turned: its diagonal is then seen.
    thin = extent[np.array(size) < LEAST_THICKNESS]
    assert ((thin > LEAST_THICKNESS - ROUNDING) & (thin < np.sqrt(3.0) * LEAST_THICKNESS + ROUNDING)).all()
    np.testing.assert_allclose(found.min(0), -found.max(0), atol=1e-8)
    assert ConvexHull(thickened(points)).volume > 0.99 * LEAST_THICKNESS**3


def test_thick_parts_stay_as_they_are():
    points = _box(0.1, 0.2, 2.0 * LEAST_THICKNESS)
    assert thickened(points) is points


def test_a_flat_sheet_is_a_thin_box():
    found = body_parts(_prop("napkin", _box(0.1, 0.2, 0.0)))
    assert not found.parts
    np.testing.assert_allclose(np.ptp(found.hull, axis=0), (0.1, 0.2, LEAST_THICKNESS), atol=1e-8)


def test_a_book_is_a_few_slices_that_contain_it_and_little_else():
    settings = PropSettings.model_validate({"kinds": ["book"]})
    book = draw_prop_of_kind(stream(1, 0, "prop"), stream(1, 0, "kind"), settings, id=2, name="book")
    assert isinstance(book, Prop)
    parts = body_parts(book).parts
    assert 3 < len(parts) < 30
    points = book.mesh.vertices.astype(np.float64)
    depth = [(points @ (planes := ConvexHull(part.points).equations)[:, :3].T + planes[:, 3]).max(1) for part in parts]
    assert np.min(depth, axis=0).max() < SIMPLIFICATION + ROUNDING
    volume = sum(ConvexHull(part.points).volume for part in parts)
    assert volume == pytest.approx(volume_of(book.mesh), rel=0.05)


def test_a_label_adds_nothing_to_the_shape_of_a_body_and_a_cap_does():
    body = body_parts(_prop("body", _box(0.05, 0.05, 0.2)))
    label = _prop("label", _box(0.06, 0.06, 0.1), category="label", part_of="body")
    cap = label.model_copy(update={"category": "cap"})
    assert with_attached(body, [label]) is body
    assert len(with_attached(body, [cap]).parts) == 2
