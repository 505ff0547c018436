"""The bodies of a scene as closed meshes in the world, and what they mean for its cameras."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...core.mesh import Mesh
from ..description.camera import Camera
from ..description.edits import in_world, solid_of
from ..description.scene import Prop, SceneObject, glass_solid
from ..description.surroundings import Table
from ..placement.overlap import Solid, contains
from ..surroundings.camera_ranges import Blocked, Workspace

#: Radius of the ball around the middle of an empty table that cameras look at [m].
EMPTY_RADIUS = 0.1


def body_mesh(item: SceneObject) -> Mesh:
    """Return the surface of an object's material, object frame: glass without its liquid, or a prop."""
    return item.mesh if isinstance(item, Prop) else glass_solid(item)


def workspace(objects: Sequence[SceneObject], table: Table) -> Workspace:
    """Return what the cameras of a scene look at: a ball around all objects, or the middle of an empty table."""
    centre, radius = _ball(objects)
    solids = {item.name: solid_of(item) for item in objects} | {"the table": in_world(table.mesh, np.eye(4))}
    vessels = [item for item in objects if not isinstance(item, Prop)] or list(objects)
    middles = np.array([item.world_T_object[:3, 3] for item in vessels] or [np.zeros(3)])
    return Workspace(
        centre=centre,
        radius=radius,
        blocked=lambda camera: _blocked(camera, solids),
        shown=lambda camera: bool(_in_both_pictures(camera, middles).any()),
    )


def _ball(objects: Sequence[SceneObject]) -> tuple[np.ndarray, float]:
    if not objects:
        return np.zeros(3), EMPTY_RADIUS
    points = np.concatenate([in_world(body_mesh(item), item.world_T_object).points for item in objects])
    centre = 0.5 * (points.min(0) + points.max(0))
    return centre, float(np.linalg.norm(points - centre, axis=1).max())


def _blocked(camera: Camera, solids: dict[str, Solid]) -> Blocked | None:
    eyes = np.array([pose[:3, 3] for pose in (camera.world_T_camera, camera.world_T_right)])
    for name, body in solids.items():
        low, high = body.points.min(0), body.points.max(0)
        near = eyes[((eyes >= low) & (eyes <= high)).all(1)]
        for eye in near[contains(body, near)] if len(near) else near:
            return Blocked(f"{_place(eye)}, in {name}", float(high[2]))
    low, high = (getattr(solids["the table"].points, end)(0) for end in ("min", "max"))
    for eye in eyes:
        if eye[2] < low[2] and (low[:2] <= eye[:2]).all() and (eye[:2] <= high[:2]).all():
            return Blocked(f"{_place(eye)}, under the table", float(high[2]))
    return None


def _place(eye: np.ndarray) -> str:
    return f"({', '.join(f'{x:.3f}' for x in eye)})"


def _in_both_pictures(camera: Camera, points: np.ndarray) -> np.ndarray:
    """Return which points (n, 3) of the world are in the left and the right picture, (n,) bool."""
    seen = np.ones(len(points), dtype=bool)
    limits = np.array([camera.width, camera.height]) - 0.5
    for pose in (camera.world_T_camera, camera.world_T_right):
        local = (points - pose[:3, 3]) @ pose[:3, :3]
        image = local @ camera.K.T
        with np.errstate(divide="ignore", invalid="ignore"):
            pixels = image[:, :2] / image[:, 2:]
        seen &= (local[:, 2] > 0.0) & ((pixels >= -0.5) & (pixels <= limits)).all(1)
    return seen
