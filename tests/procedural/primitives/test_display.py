"""Objects side by side for a contact sheet."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.procedural.description.scene import SceneObject
from glassware.procedural.optics.medium import Medium
from glassware.procedural.primitives.bodies import ball, box_mesh
from glassware.procedural.primitives.display import display
from glassware.procedural.primitives.scenes import block, matte
from glassware.procedural.scene.validate import check_scene


@pytest.mark.parametrize("count", [1, 5])
def test_each_object_stands_alone_before_a_camera_of_its_own(count: int) -> None:
    objects: list[SceneObject] = [
        block(box_mesh((0.1, 0.06, 0.04), f"box-{i}"), matte(), id=2 + i) for i in range(count)
    ]
    objects.append(ball(0.05, Medium(name="glass", eta=1.5), id=2 + count, name="ball"))
    scene = display(objects, width=48, height=40)
    check_scene(scene)
    assert len(scene.cameras) == count + 1
    placed = {item.id: item for item in scene.objects}
    for camera, item in zip(scene.cameras, objects, strict=True):
        place = np.append(placed[item.id].world_T_object[:3, 3], 1.0)
        x, y, z = (np.linalg.inv(camera.world_T_camera) @ place)[:3]
        assert abs(x) < 1e-9
        assert abs(y) < 1e-9
        # The bounding ball fits the height of the picture.
        assert 0.5 * np.linalg.norm(item.size) / z * camera.focal < 0.5 * camera.height
