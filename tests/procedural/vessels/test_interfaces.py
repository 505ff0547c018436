from __future__ import annotations

import numpy as np
import pytest

from glassware.core.mesh import Mesh
from glassware.procedural.description.scene import Vessel, glass_solid, liquid_solid
from glassware.procedural.optics.medium import AIR, Medium
from glassware.procedural.profiles.curve import Curve, arc
from glassware.procedural.profiles.cuts import cut_at


def _part(vessel: Vessel, name: str) -> Mesh:
    return next(interface.mesh for interface in vessel.interfaces if interface.part == name)


def test_a_full_vessel_has_three_interfaces_with_their_media_and_an_empty_one_has_one(many_vessels):
    for vessel in many_vessels:
        media = {i.part: (i.front.name, i.back.name) for i in vessel.interfaces}
        expected = {"outside": ("air", vessel.glass.name)}
        if vessel.liquid is not None:
            liquid = vessel.liquid.medium.name
            expected |= {"wet_wall": (liquid, vessel.glass.name), "liquid_surface": ("air", liquid)}
        assert media == expected


def test_glass_is_as_rough_as_the_vessel_and_liquids_are_smooth(many_vessels):
    for vessel in many_vessels:
        for interface in vessel.interfaces:
            assert interface.roughness == (0.0 if interface.part == "liquid_surface" else vessel.roughness)


def test_the_three_interfaces_share_the_contact_line_bit_for_bit(full_vessels):
    for vessel in full_vessels:
        height = np.float32(vessel.liquid.contact)
        rings = []
        for name in ("outside", "wet_wall", "liquid_surface"):
            vertices = _part(vessel, name).vertices
            radius = np.hypot(vertices[:, 0], vertices[:, 1])
            contact = np.interp(vessel.liquid.contact, *np.array(vessel.inner).T[::-1])
            ring = vertices[(vertices[:, 2] == height) & (np.abs(radius - contact) < 1e-7)]
            rings.append({tuple(row) for row in ring.view(np.uint32).tolist()})
        # All rings of the surface have as many vertices; one more stands on the axis.
        assert len(rings[0]) > 50
        assert (len(_part(vessel, "liquid_surface").vertices) - 1) % len(rings[0]) == 0
        assert rings[0] == rings[1] == rings[2]


def _media_along(hits, vessel: Vessel, origin: np.ndarray, direction: np.ndarray) -> tuple[list[Medium], np.ndarray]:
    """Media of the stretches of a ray, each vouched for by the crossings on both of its sides, and the distances."""
    crossings = []
    for interface in vessel.interfaces:
        for distance, from_front in zip(*hits(interface.mesh, origin, direction), strict=True):
            pair = (interface.front, interface.back) if from_front else (interface.back, interface.front)
            crossings.append((distance, pair))
    crossings.sort(key=lambda crossing: crossing[0])
    media = [AIR]
    for _, (left, entered) in crossings:
        assert media[-1] == left
        media.append(entered)
    assert media[-1] == AIR
    return media, np.array([distance for distance, _ in crossings])


def test_media_along_random_rays_agree_with_the_closed_bodies(full_vessels, media_rays, rng):
    met = set()
    for vessel in full_vessels:
        points, expected = [], []
        for _ in range(10):
            target = rng.uniform(-0.5, 0.5, 3) * vessel.size
            direction = rng.normal(size=3)
            direction /= np.linalg.norm(direction)
            origin = target - direction
            media, distances = _media_along(media_rays.hits, vessel, origin, direction)
            for medium, near, far in zip(media[1:-1], distances[:-1], distances[1:], strict=True):
                points.append(origin + 0.5 * (near + far) * direction)
                expected.append(medium)
        in_glass = media_rays.winding(glass_solid(vessel), np.array(points))
        in_liquid = media_rays.winding(liquid_solid(vessel), np.array(points))
        assert set(np.unique(in_glass)) <= {0.0, 1.0}
        assert set(np.unique(in_liquid)) <= {0.0, 1.0}
        assert not ((in_glass == 1.0) & (in_liquid == 1.0)).any()
        for medium, glass, liquid in zip(expected, in_glass, in_liquid, strict=True):
            found = vessel.glass if glass else vessel.liquid.medium if liquid else AIR
            assert found == medium
            met.add(medium.name)
    assert met == {"air", "test glass", "test water", "test spirit"}


def test_an_empty_vessel_has_no_liquid_body(many_vessels):
    empty = next(vessel for vessel in many_vessels if vessel.liquid is None)
    with pytest.raises(ValueError, match="expected a liquid"):
        liquid_solid(empty)


def test_a_cut_next_to_a_point_of_the_profile_makes_no_needle():
    curve = arc(np.array([0.0, 0.05]), 0.05, -np.pi / 2, 0.0)
    curve = Curve(curve.points - (0.0, 0.0), -curve.normals)
    near = curve.points[20] + (0.0, 5e-8)
    below, above = cut_at(curve, near)
    assert len(below.points) + len(above.points) == len(curve.points) + 1
    np.testing.assert_array_equal(below.points[-1], near)
    np.testing.assert_array_equal(above.points[0], near)
