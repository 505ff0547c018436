"""What a room costs in the path tracer: as a map at infinity and as geometry. Study of 28 November 2026.

    python bench/studies/room_as_geometry.py --seeds 1 4 7

Backs the table in docs/design.md, "A room is a map at infinity".

- map: the room as it is seen from the table's centre, as an environment map (the product).
- geometry: walls, floor and furniture are diffuse meshes; windows and lamps are area lights of about the same radiance.

All pictures of a scene have the same samples per pixel; each method is compared with a reference of its own. Printed
are the processor time of a picture (all cores) and the relative mean squared error of the exposed values, before and
after the denoiser.
"""

from __future__ import annotations

import argparse
from time import process_time

import numpy as np
from rich.console import Console

from glassware.core.mesh import Mesh
from glassware.procedural.description.material import OpaqueMaterial, UniformTexture
from glassware.procedural.description.scene import Prop, Scene
from glassware.procedural.description.surroundings import AreaLight, RoomEnvironment, Window
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.surroundings.camera_settings import CameraSettings
from glassware.procedural.surroundings.room_geometry import (
    WALL_FACES,
    Boxes,
    boxes_of,
    face_axis,
    face_frames,
    face_points,
)
from glassware.procedural.surroundings.settings import EnvironmentSettings
from glassware.render.backend.variant import activate

#: Factor on the radiance of the map behind the geometry: rays do not leave the closed room.
_DARK = 1e-6
#: Mean radiance over the stated one: a window shows land below the horizon, a lamp fades at its rim.
_MEAN_LEVEL = 0.7
#: Keeps the relative error finite in dark pixels, in exposed values squared.
_EPSILON = 1e-2


def as_geometry(scene: Scene) -> Scene:
    """Return the scene with its room as meshes and area lights."""
    room = scene.environment
    if not isinstance(room, RoomEnvironment):
        raise TypeError(f"environment: expected a room, found {room.kind}")
    boxes = boxes_of(room)
    world_T_room = np.eye(4)
    cos, sin = np.cos(room.rotation), np.sin(room.rotation)
    world_T_room[:2, :2] = [[cos, -sin], [sin, cos]]
    world_T_room[:3, 3] = -world_T_room[:3, :3] @ np.array(room.eye)
    first = max((item.id for item in scene.objects), default=1) + 1
    walls = tuple(_wall(boxes, face, first + face, world_T_room) for face in range(6 * len(boxes.lower)))
    lights = tuple(_light(boxes, window, room.strength, world_T_room) for window in room.windows)
    dark = room.model_copy(update={"strength": _DARK * room.strength})
    changed = {"props": (*scene.props, *walls), "lights": (*scene.lights, *lights), "environment": dark}
    return scene.model_copy(update=changed)


def _wall(boxes: Boxes, face: int, id: int, world_T_room: np.ndarray) -> Prop:
    corner, size, _ = face_frames(boxes)
    coordinates = corner[face] + np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * size[face]
    vertices = face_points(boxes, np.full(4, face), coordinates)
    name, colour = f"wall-{face:02d}", _triple(boxes.reflectance[face])
    material = OpaqueMaterial(name=name, base_colour=UniformTexture(colour=colour), roughness=1.0)
    mesh = Mesh(name=name, vertices=vertices, faces=np.array([[0, 1, 2], [0, 2, 3]]))
    extent = _triple(np.ptp(vertices, axis=0))
    return Prop(
        id=id, name=name, category="wall", mesh=mesh, material=material, size=extent, world_T_object=world_T_room
    )


def _light(boxes: Boxes, window: Window, strength: float, world_T_room: np.ndarray) -> AreaLight:
    face = WALL_FACES[window.wall]
    inward = face_frames(boxes)[2][face].astype(float)
    along = np.eye(3)[[k for k in range(3) if k != face_axis(np.array([face]))[0]]]
    if np.cross(along[0], along[1]) @ inward < 0:
        along[0] = -along[0]
    pose = np.eye(4)
    pose[:3, :3] = np.stack([*along, inward], axis=1)
    # One millimetre before the wall.
    pose[:3, 3] = face_points(boxes, np.array([face]), np.array([window.centre]))[0] + 1e-3 * inward
    radiance = _triple(_MEAN_LEVEL * strength * np.array(window.radiance))
    return AreaLight(world_T_light=world_T_room @ pose, size=window.size, radiance=radiance)


def _triple(values: np.ndarray) -> tuple[float, float, float]:
    first, second, third = map(float, values)
    return first, second, third


def _row(scene: Scene, spp: int, reference_spp: int) -> tuple[float, float, float]:
    """Return the time of a picture [s] and its relative squared error before and after the denoiser."""
    # These modules need the variant that `main` sets.
    from glassware.render.pictures.picture import denoise_image, trace_picture
    from glassware.render.scene.loaded_scene import load

    few = scene.picture.model_copy(update={"spp": spp, "light": "path"})
    many = few.model_copy(update={"spp": reference_spp})
    loaded, camera = load(scene.model_copy(update={"picture": few})), scene.cameras[0]
    trace_picture(loaded, camera, "left", 1)  # compiles
    start = process_time()
    noisy = trace_picture(loaded, camera, "left", 2)
    seconds = process_time() - start
    reference = trace_picture(load(scene.model_copy(update={"picture": many})), camera, "left", 3).radiance
    before = _relative(noisy.radiance, reference, camera.exposure)
    return seconds, before, _relative(denoise_image(noisy), reference, camera.exposure)


def _relative(found: np.ndarray, reference: np.ndarray, exposure: float) -> float:
    """Return the relative mean squared error, of values as they are shown (at most 1)."""
    a, b = (np.minimum(exposure * x.astype(float), 1.0) for x in (found, reference))
    return float(((a - b) ** 2 / (b**2 + _EPSILON)).mean())


def _check_camera(scene: Scene) -> None:
    """Raise where the camera stands behind a wall: the two methods then show different pictures."""
    room, world = scene.environment, scene.cameras[0].world_T_camera[:3, 3]
    if not isinstance(room, RoomEnvironment):
        raise TypeError(f"environment: expected a room, found {room.kind}")
    cos, sin = np.cos(room.rotation), np.sin(room.rotation)
    place = np.add(room.eye, (cos * world[0] + sin * world[1], cos * world[1] - sin * world[0], world[2]))
    if not ((place > 0.0) & (place < room.size)).all():
        raise ValueError(f"camera: expected a place in the room {room.size}, found {place}")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Compare a room as a map at infinity with the room as geometry.")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 4, 7], help="seeds whose scenes are rooms")
    parser.add_argument("--width", type=int, default=64, help="width of the pictures [px]")
    parser.add_argument("--height", type=int, default=48, help="height of the pictures [px]")
    parser.add_argument("--spp", type=int, default=32, help="samples per pixel")
    parser.add_argument("--reference-spp", type=int, default=512, help="samples per pixel of the references")
    request = parser.parse_args()
    activate("llvm_ad_rgb")
    out = Console(highlight=False, soft_wrap=True)
    out.print(f"{'seed':>4} {'room':>9} {'time [s]':>9} {'relMSE noisy':>13} {'relMSE clean':>13}")
    for seed in request.seeds:
        cameras = CameraSettings(views=1, width=request.width, height=request.height)
        settings = SceneSettings(cameras=cameras, environment=EnvironmentSettings(shipped_share=0.0))
        scene = draw_scene(settings, seed, 0)
        _check_camera(scene)
        for name, described in {"map": scene, "geometry": as_geometry(scene)}.items():
            seconds, before, after = _row(described, request.spp, request.reference_spp)
            out.print(f"{seed:4d} {name:>9} {seconds:9.2f} {before:13.2e} {after:13.2e}")


if __name__ == "__main__":
    main()
