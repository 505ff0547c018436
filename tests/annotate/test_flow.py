"""Optical flow leads to the same point, and its visibility is that of a ray to it."""

from __future__ import annotations

import numpy as np

from glassware.annotate.flow import flow_visibility, optical_flow
from glassware.annotate.projection import project, transformed, unproject


def test_flow_leads_to_where_the_point_is_and_rays_agree_on_what_is_visible(analytic):
    scene = analytic.scene(views=2)
    here, there = scene.cameras
    Z, other = analytic.geometry(scene, here).Z, analytic.geometry(scene, there).Z
    flow, seen = optical_flow(Z, here, there), flow_visibility(Z, here, other, there)
    hit = np.isfinite(Z)
    points = transformed(here.world_T_camera, unproject(Z, here.K)[hit])
    v, u = np.nonzero(hit)
    pixels, _ = project(points, there.K, there.world_T_camera)
    np.testing.assert_allclose(flow[hit] + np.stack([u, v], axis=1), pixels, atol=1e-4)
    assert np.isnan(flow[~hit]).all()
    assert not seen[~hit].any()
    distance = np.linalg.norm(points - there.world_T_camera[:3, 3], axis=1)
    inside = (np.abs(pixels + 0.5 - np.array([80, 60])) < [80, 60]).all(axis=1)
    free = analytic.sight(scene, there, points).first_distance > distance - 1e-6
    # At silhouettes the four pixels around a point show two surfaces.
    assert ((free & inside) != seen[hit]).mean() < 0.03


def test_a_view_has_no_flow_to_itself(analytic):
    scene = analytic.scene(views=1)
    (camera,) = scene.cameras
    Z = analytic.geometry(scene, camera).Z
    hit = np.isfinite(Z)
    np.testing.assert_allclose(optical_flow(Z, camera, camera)[hit], 0.0, atol=1e-9)
    assert flow_visibility(Z, camera, Z, camera)[hit].all()
