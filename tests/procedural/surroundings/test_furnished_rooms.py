"""Furnished rooms hold their cameras, hide nothing, and stand on their floor."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.procedural.description.surroundings import RoomEnvironment
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.scene.validate import check_scene
from glassware.procedural.surroundings.camera_settings import CameraSettings
from glassware.procedural.surroundings.room_bodies import room_bodies, world_T_room
from glassware.procedural.surroundings.rooms import TABLE_HEIGHT
from glassware.procedural.surroundings.settings import EnvironmentSettings

_ROOMS = EnvironmentSettings(room_depth=True, shipped_share=0.0, room_share=1.0)


@pytest.fixture(scope="module", params=[11, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (12, 13))])
def scene(request):
    return draw_scene(SceneSettings(environment=_ROOMS, cameras=CameraSettings(views=5)), request.param, 0)


def test_cameras_stand_in_the_room_outside_of_all_furniture(scene) -> None:
    check_scene(scene)
    room = scene.environment
    assert isinstance(room, RoomEnvironment)
    assert not room.at_infinity
    room_T_world = np.linalg.inv(world_T_room(room))
    for camera in scene.cameras:
        for pose in (camera.world_T_camera, camera.world_T_right):
            eye = room_T_world[:3, :3] @ pose[:3, 3] + room_T_world[:3, 3]
            assert ((eye > 0.0) & (eye < room.size)).all()
            for block in room.blocks:
                assert not ((eye > block.lower) & (eye < block.upper)).all()
            for detail in room.details:
                local = np.linalg.inv(np.asarray(detail.room_T_detail)) @ [*eye, 1.0]
                assert not (np.abs(local[:3]) < 0.5 * np.array(detail.size)).all()


def test_the_table_stands_on_the_floor_on_legs(scene) -> None:
    legs = [detail for detail in scene.environment.details if detail.part == "table-leg"]
    lowest = min(np.asarray(leg.room_T_detail)[2, 3] - 0.5 * leg.size[2] for leg in legs)
    highest = max(np.asarray(leg.room_T_detail)[2, 3] + 0.5 * leg.size[2] for leg in legs)
    under = TABLE_HEIGHT - scene.table.size[2]
    assert lowest == pytest.approx(0.0, abs=0.002)
    assert under - 0.005 < highest <= under + 1e-6


def test_walls_have_holes_where_windows_are_and_their_surfaces_add_up(scene) -> None:
    room, area = scene.environment, 0.0
    for body in room_bodies(room):
        # Skirting boards and doors have plain colours, in a palette of one row.
        if body.part in ("wall", "floor", "ceiling") and len(body.pixels) > 1:
            p = body.mesh.vertices[body.mesh.faces].astype(float)
            area += 0.5 * float(np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum())
    x, y, z = room.size
    holes = sum(w.size[0] * w.size[1] for w in room.windows if w.kind == "window")
    assert area == pytest.approx(2 * (x * y + y * z + z * x) - holes, rel=1e-5)


def _pixel(camera, world_T_camera: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the pixels (n, 2) of points in world coordinates, and their depth."""
    local = (points - world_T_camera[:3, 3]) @ world_T_camera[:3, :3]
    return (local @ camera.K.T)[:, :2] / local[:, 2:], local[:, 2]


def _disparities(scene, points: np.ndarray) -> np.ndarray:
    """Return the disparities [px] of points in the room's frame, in each view of whose left picture they are."""
    pose, found = world_T_room(scene.environment), []
    points = points @ pose[:3, :3].T + pose[:3, 3]
    for camera in scene.cameras:
        (left, depth), (right, _) = (
            _pixel(camera, eye, points) for eye in (camera.world_T_camera, camera.world_T_right)
        )
        size = (camera.width - 1, camera.height - 1)
        seen = (depth > 0.0) & ((left >= 0.0) & (left <= size)).all(axis=1)
        shift = (left - right)[seen]
        np.testing.assert_allclose(shift[:, 0], camera.focal * camera.baseline / depth[seen], atol=1e-6)
        np.testing.assert_allclose(shift[:, 1], 0.0, atol=1e-6)
        found.append(shift[:, 0])
    return np.concatenate(found)


def test_walls_and_the_legs_of_the_table_have_the_disparity_of_their_depth(scene) -> None:
    walls = np.concatenate([body.mesh.vertices for body in room_bodies(scene.environment) if body.part == "wall"])
    legs = np.array([np.asarray(d.room_T_detail)[:3, 3] for d in scene.environment.details if d.part == "table-leg"])
    of_walls, of_legs = _disparities(scene, walls), _disparities(scene, legs)
    # 640 px wide pictures: a wall 5 m away moves by 3 px or more, and what stands nearer by more.
    assert len(of_walls) > 100
    assert of_walls.min() > 3.0
    assert len(of_legs) > 0
    assert of_legs.min() > of_walls.min()
