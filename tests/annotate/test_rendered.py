"""The renderer's geometry against closed forms that share nothing with it, and the labels made from each."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.annotate.keypoints import scene_keypoints
from glassware.annotate.labels import annotate
from glassware.dataset.verification.geometry import geometry_faults
from glassware.render.labels.geometry import line_of_sight, trace_geometry
from glassware.render.scene.loaded_scene import load

#: The glass is a prism of 256 sides, the ball 5120 triangles: a silhouette may miss a pixel centre here and there.
EDGE_PIXELS = 5


@pytest.mark.parametrize("number", [0, 1, 3])
def test_rendered_geometry_and_labels_agree_with_closed_forms(analytic, backend, number):
    # Mitsuba can only be imported once a variant is set, which `backend` does.

    scene = analytic.scene(views=4)
    camera, points, kernel = scene.cameras[number], scene_keypoints(scene), load(scene)
    world = points.world.reshape(-1, 3)
    left, right = (trace_geometry(kernel, camera, eye) for eye in ("left", "right"))
    labels = annotate(
        scene, camera, left, points, line_of_sight(kernel, camera.world_T_camera[:3, 3].astype(float), world)
    )
    assert geometry_faults(scene, camera, left) == []
    assert geometry_faults(scene, camera, right, "right") == []

    exact = analytic.geometry(scene, camera)
    expected = annotate(scene, camera, exact, points, analytic.sight(scene, camera, world))
    assert (left.id != exact.id).sum() <= EDGE_PIXELS
    assert (left.background_id != exact.background_id).sum() <= EDGE_PIXELS
    assert (left.crossed != exact.crossed).sum() <= EDGE_PIXELS
    assert (left.reached != exact.reached).sum() <= EDGE_PIXELS
    same = (left.id == exact.id) & (left.id > 0)
    # Facets of the ball stand 0.1 mm inside it, which a ray that grazes them meets some ten times later.
    assert np.abs(left.Z[same] - exact.Z[same]).max() < 2.5e-3
    assert np.quantile(np.abs(left.Z[same] - exact.Z[same]), 0.95) < 1e-4
    states = [[point.state for point in label.keypoints] for label in labels.objects]
    assert states == [[point.state for point in label.keypoints] for label in expected.objects]
