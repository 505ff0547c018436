from __future__ import annotations

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.procedural.optics.capillary import GRAVITY, capillary_length
from glassware.procedural.optics.medium import Medium
from glassware.procedural.profiles.curve import Curve, arc, chained
from glassware.procedural.profiles.liquid import RIM_MARGIN, brimful_volume, level_of_volume, volume_below
from glassware.procedural.profiles.liquid_surface import LEAST_ANGLE, Surface, most_volume, surface_of_volume

CHORD = 15e-6
ANGLE = float(np.radians(25.0))
WATER = Medium(name="water", eta=1.33, density=998.2, surface_tension=0.07274, contact_angle=ANGLE)
LENGTH = capillary_length(998.2, 0.07274)


def _cone(bottom: float, top: float, height: float) -> Curve:
    """A vessel with a flat floor and a straight wall; the floor has its own normal, and so has the wall."""
    wall = np.array([[bottom, 0.0], [top, height]])
    normal = np.array([-height, top - bottom]) / np.hypot(height, top - bottom)
    points = np.array([[0.0, 0.0], [bottom, 0.0], wall[0], wall[1]])
    return Curve(points, np.array([[0.0, 1.0], [0.0, 1.0], normal, normal]))


def _tube(radius: float, height: float) -> Curve:
    return _cone(radius, radius, height)


def _round_bowl(radius: float) -> Curve:
    """The lower half of a sphere with a straight collar of 2 cm."""
    half = arc(np.array([0.0, 0.0]), radius, -0.5 * np.pi, 0.0)
    half.points[0, 0] = 0.0
    bowl = Curve(half.points, -half.normals)
    collar = Curve(np.array([[radius, 0.0], [radius, 0.02]]), np.array([[-1.0, 0.0], [-1.0, 0.0]]))
    return chained(bowl, collar)


def _angle_at_wall(surface: Surface, wall_normal: np.ndarray) -> float:
    """Angle inside the liquid, from the surface's own normal and the wall's (both point out of the liquid's wedge)."""
    return float(np.arccos(np.clip(surface.top.normals[-1] @ wall_normal, -1.0, 1.0)))


@pytest.mark.parametrize("lean", [-45.0, -20.0, 0.0, 10.0, 40.0])
def test_the_surface_meets_straight_walls_at_its_contact_angle(lean):
    inner = _cone(0.05, 0.05 + 0.08 * np.tan(np.radians(lean)) * (0.5 if lean < 0 else 1.0), 0.08)
    surface = surface_of_volume(inner, 0.4 * brimful_volume(inner.points), WATER, CHORD)
    assert surface.contact_angle == pytest.approx(ANGLE, abs=1e-12)
    assert _angle_at_wall(surface, inner.normals[-1]) == pytest.approx(ANGLE, abs=1e-7)
    # The polygon itself, whose last chord turns from the surface's tangent by half of the normal's last step.
    step = surface.top.points[-1] - surface.top.points[-2]
    chord = np.arctan2(step[1], step[0])
    end, before = (np.arctan2(-n[0], n[1]) for n in surface.top.normals[[-1, -2]])
    assert before < chord < end


@pytest.mark.parametrize("share", [0.1, 0.3, 0.5])
def test_the_surface_meets_a_round_bowl_at_its_contact_angle(share):
    inner = _round_bowl(0.05)
    surface = surface_of_volume(inner, share * brimful_volume(inner.points), WATER, CHORD)
    r, z = surface.top.points[-1]
    # On the sphere the wall's normal points at its centre; between points 2 degrees apart it is interpolated.
    assert _angle_at_wall(surface, -np.array([r, z]) / np.hypot(r, z)) == pytest.approx(ANGLE, abs=2e-4)


def test_the_meshes_normals_meet_at_the_contact_angle(full_vessels):
    for vessel in full_vessels:
        parts = {interface.part: interface.mesh for interface in vessel.interfaces}
        top, wall = parts["liquid_surface"], parts["wet_wall"]
        ring = np.flatnonzero(top.vertices[:, 2] == np.float32(vessel.liquid.contact))
        on_wall = {tuple(row): normal for row, normal in zip(wall.vertices.tolist(), wall.normals, strict=True)}
        cosines = [top.normals[i].astype(float) @ on_wall[tuple(top.vertices[i].tolist())] for i in ring]
        # Normals of float32; at 10 degrees an error of 1e-7 in the cosine is one of 6e-7 in the angle.
        expected = max(vessel.liquid.medium.contact_angle, LEAST_ANGLE)
        assert np.arccos(cosines) == pytest.approx(expected, abs=5e-6)
        assert vessel.liquid.contact_angle == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("inner", [_tube(0.03, 0.1), _cone(0.02, 0.05, 0.1), _cone(0.05, 0.03, 0.1), _round_bowl(0.06)])
@pytest.mark.parametrize("share", [0.2, 0.8])
def test_the_volume_is_the_one_that_was_asked_for(inner, share):
    asked = share * brimful_volume(inner.points)
    surface = surface_of_volume(inner, asked, WATER, CHORD)
    assert surface.volume == pytest.approx(asked, rel=5e-7)
    # And the stated one is that of the body: washers between surface and wall, an independent quadrature.
    top = surface.top.points
    floor, height = inner.points.T
    z = np.linspace(inner.points[0, 1], max(top[:, 1].max(), surface.contact), 200_001)
    wall = np.interp(z, height, floor)
    air = np.interp(z, top[:, 1], top[:, 0]) * (z >= top[0, 1])
    slices = np.pi * (wall**2 - np.where(z >= top[0, 1], air, 0.0) ** 2)
    assert np.trapezoid(slices, z) == pytest.approx(surface.volume, rel=1e-4)


def test_the_contact_line_of_a_tube_stands_where_the_balance_of_forces_puts_it():
    # Above the level of zero pressure the wall carries rho g V = 2 pi R gamma cos(theta); below it stands a cylinder.
    radius, asked = 0.03, 1.5e-4
    surface = surface_of_volume(_tube(radius, 0.1), asked, WATER, 2e-6)
    carried = 2.0 * np.pi * radius * 0.07274 * np.cos(ANGLE) / (998.2 * GRAVITY)
    zero = (asked - carried) / (np.pi * radius**2)
    # Eleven capillary lengths from the wall, the middle lies above that level by about exp(-11) of 3 mm; the polygon of
    # as much volume lies lower than the true curve by up to its chord error.
    assert surface.centre == pytest.approx(zero, abs=2.5e-6)
    # The flat wall's height, within the order of lc / R (de Gennes et al. 2004, sec. 2.3).
    flat = LENGTH * np.sqrt(2.0 * (1.0 - np.sin(ANGLE)))
    assert surface.contact - zero == pytest.approx(flat, rel=LENGTH / radius)


def test_a_bowl_of_15_cm_is_flat_in_the_middle():
    surface = surface_of_volume(_tube(0.075, 0.06), 5e-4, WATER, CHORD)
    r = np.linspace(0.0, 0.04, 101)
    z = np.interp(r, *surface.top.points.T)
    # 13 capillary lengths from the wall the surface has risen by less than 2 micrometres, by exp(-13) times 3 mm.
    assert np.ptp(z) < 2e-6
    assert surface.contact - surface.centre > 2.5e-3


def test_a_narrow_tube_has_a_spherical_cap():
    radius = 0.1 * LENGTH
    surface = surface_of_volume(_tube(radius, 0.02), np.pi * radius**2 * 0.01, WATER, 2e-6)
    r, z = surface.top.points.T
    sphere = radius / np.cos(ANGLE)
    cap = sphere - np.sqrt(sphere**2 - r**2)
    # Gravity flattens it by the order (R / lc)^2 = 1 %.
    assert np.abs(z - z[0] - cap).max() < 0.01 * radius
    assert z[-1] - z[0] > 0.5 * radius


def test_a_liquid_that_wets_meets_the_wall_at_the_least_angle():
    spirit = WATER.model_copy(update={"contact_angle": 0.0})
    inner = _tube(0.03, 0.1)
    surface = surface_of_volume(inner, 1e-4, spirit, CHORD)
    assert surface.contact_angle == pytest.approx(LEAST_ANGLE)
    assert _angle_at_wall(surface, np.array([-1.0, 0.0])) == pytest.approx(LEAST_ANGLE, abs=1e-7)
    # What that costs in height is what the constant's comment says.
    rise = surface.contact - surface.centre
    assert 1.0 - rise / (np.sqrt(2.0) * LENGTH) == pytest.approx(0.091, abs=0.5 * LENGTH / 0.03)


def test_a_liquid_without_its_constants_is_flat():
    inner = _cone(0.02, 0.05, 0.1)
    for missing in ("density", "surface_tension", "contact_angle"):
        surface = surface_of_volume(inner, 1e-4, WATER.model_copy(update={missing: None}), CHORD)
        assert len(surface.top.points) == 2
        assert surface.centre == surface.contact == level_of_volume(inner.points, 1e-4)
        assert surface.volume == pytest.approx(1e-4, rel=1e-9)


def test_a_liquid_that_does_not_wet_sinks_at_the_wall():
    mercury = WATER.model_copy(update={"contact_angle": float(np.radians(140.0))})
    inner = _tube(0.03, 0.1)
    surface = surface_of_volume(inner, 1e-4, mercury, CHORD)
    assert surface.contact < surface.centre
    assert surface.volume == pytest.approx(1e-4, rel=5e-7)
    assert _angle_at_wall(surface, np.array([-1.0, 0.0])) == pytest.approx(np.radians(140.0), abs=1e-7)


def test_on_a_wavy_wall_the_surface_never_cuts_the_wall_and_says_where_it_bends_less():
    # Waves of 5 mm length and 2 mm height: the wall curves within the meniscus.
    z = np.linspace(0.0, 0.06, 2401)
    r, slope = 0.02 + 0.002 * np.sin(z * 400.0 * np.pi), 0.8 * np.pi * np.cos(z * 400.0 * np.pi)
    wall = np.stack([-np.ones_like(z), slope], axis=-1) / np.hypot(1.0, slope)[:, None]
    points = np.concatenate([[[0.0, 0.0]], np.stack([r, z], axis=-1)])
    inner = Curve(points, np.concatenate([[[0.0, 1.0]], wall]))
    angles = []
    for volume in (4.00e-5, 4.12e-5):
        surface = surface_of_volume(inner, volume, WATER, CHORD)
        assert surface.volume == pytest.approx(volume, rel=1e-5)
        heights = np.linspace(surface.centre, surface.contact, 2001)[1:-1]
        room = np.interp(heights, z, r) - np.interp(heights, *surface.top.points.T[::-1])
        assert (room > 0.0).all()
        normal = [np.interp(surface.contact, z, column) for column in wall.T]
        assert _angle_at_wall(surface, normal / np.hypot(*normal)) == pytest.approx(surface.contact_angle, abs=1e-4)
        angles.append(surface.contact_angle)
    assert angles[0] == pytest.approx(ANGLE)
    assert ANGLE + 0.1 < angles[1] < 0.5 * np.pi


def test_a_meniscus_above_the_rim_is_refused_in_one_line():
    inner = _tube(0.03, 0.1)
    most = most_volume(inner, WATER)
    assert surface_of_volume(inner, most, WATER, CHORD).contact == pytest.approx(0.1 - RIM_MARGIN, abs=CHORD)
    # A flat liquid of this volume would still fit: it is the meniscus that does not.
    assert 1.01 * most < volume_below(inner.points, 0.1 - RIM_MARGIN)
    with pytest.raises(InputError, match=r"liquid.volume: expected at most .* \(below the rim\), found"):
        surface_of_volume(inner, 1.01 * most, WATER, CHORD)


@pytest.mark.parametrize(("wall", "degrees"), [("PET", 72.5), ("polycarbonate", 82.0), ("polypropylene", 102.1)])
def test_water_in_plastic_rises_or_sinks_as_at_a_plane_wall(wall, degrees):
    surface = surface_of_volume(_tube(0.06, 0.1), 4e-4, WATER, CHORD, Medium(name=wall, eta=1.5))
    angle = np.radians(degrees)
    assert surface.contact_angle == pytest.approx(angle, abs=1e-9)
    assert _angle_at_wall(surface, np.array([-1.0, 0.0])) == pytest.approx(angle, abs=1e-7)
    # de Gennes et al. 2004, eq. 2.15: 2 lc sin((90 deg - angle) / 2), negative where the liquid does not wet; a round
    # wall differs by the order of lc / R.
    plane = 2.0 * LENGTH * np.sin(0.5 * (0.5 * np.pi - angle))
    assert surface.contact - surface.centre == pytest.approx(plane, rel=LENGTH / 0.06)
    assert (surface.contact > surface.centre) == (degrees < 90.0)
    # The surface is convex where it sinks: its height falls all the way to the wall.
    assert (np.sign(np.diff(surface.top.points[:, 1])) == np.sign(90.0 - degrees)).all()


def test_a_volume_that_is_the_most_up_to_rounding_fits():
    for inner in (_tube(0.03, 0.1), _cone(0.02, 0.04, 0.1)):
        most = most_volume(inner, WATER)
        for excess in (0.0, 1e-13, 1e-10):
            surface = surface_of_volume(inner, most * (1.0 + excess), WATER, CHORD)
            assert surface.contact == pytest.approx(0.1 - RIM_MARGIN, abs=CHORD)
