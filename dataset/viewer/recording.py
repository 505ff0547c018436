"""A recording for Rerun (``.rrd``): cameras with pictures and maps, meshes, boxes, keypoints and clouds.

Timelines ``view`` and ``scene`` count what is in the recording; ``world`` is our world, z up, in metres. Maps have the
steps of `label_maps`, which the entity's description states. Of the library only this module knows; it loads on use.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import cv2
import numpy as np

from ...annotate.labels import Labels
from ...core.errors import InputError
from ...core.images import NOTHING, difference_colours, hue_colours, id_colour, srgb_curve
from ...procedural.description.camera import Camera
from ...procedural.description.scene import TABLE_ID, Prop, Scene
from ...render.frame import EYES, Eye
from ..format import layout
from ..format.dataset_file import DatasetFile
from ..reader import StoredView
from .bodies import MOST_TRIANGLES, simplified, view_points
from .choice import Choice
from .label_maps import view_maps
from .map_numbers import LabelMap, reduced
from .sensor_maps import infrared_pictures

#: Length of a camera's pyramid in the view [m], and radius of a point of a cloud [m].
_PYRAMID, _POINT = 0.12, 0.001
#: Alpha of a glass surface in the view [1 of 255].
_GLASS = 70
#: Colours of keypoints by state.
_STATES = {
    "visible": (80, 225, 95),
    "through_glass": (70, 190, 255),
    "occluded": (240, 75, 65),
    "outside": (250, 190, 50),
}
#: An id with its name and colour.
_Class = tuple[int, str, tuple[int, int, int]]
_INSTALL = "the library of Rerun, as in pip install 'glassware[view]'"


def rerun_library() -> ModuleType:
    """Return the library of Rerun; InputError in one line where it is not installed."""
    try:
        import rerun  # pyright: ignore[reportMissingImports]
    except ModuleNotFoundError as error:
        raise InputError("--rerun", _INSTALL, error) from error
    return rerun


def write_recording(
    path: Path,
    head: DatasetFile,
    choices: Sequence[Choice],
    width: int,
    each: Callable[[Iterable[Any]], Iterable[Any]] = iter,
) -> None:
    """Write a recording with its blueprint.

    Parameters
    ----------
    path : Path
        The file to write; another one is replaced.
    head : DatasetFile
        ``dataset.json``.
    choices : sequence of Choice
        What is in it.
    width : int
        Most columns of pictures and maps [px]; larger ones are reduced.
    each : callable, optional
        Goes through the scenes, and may show how far it is.

    Raises
    ------
    InputError
        Where the library is missing, or a file of the data set is missing or damaged.
    """
    rr = rerun_library()
    recording = rr.RecordingStream("glassware")
    names, classes = _map_names(choices[0]), _classes(choices)
    recording.send_recording_name(head.name)
    recording.save(path, default_blueprint=_blueprint(names))
    recording.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    count = 0
    for place, choice in enumerate(each(choices)):
        recording.set_time("scene", sequence=choice.scene.scene_id)
        recording.set_time("view", sequence=count)
        scene = choice.scene.scene()
        if place:
            recording.log("world", rr.Clear(recursive=True))
        _log_scene(rr, recording, scene)
        for number, view in enumerate(choice.views):
            recording.set_time("view", sequence=count)
            _log_view(rr, recording, view, choice.following(number), width, classes)
            count += 1
    recording.flush()
    recording.disconnect()


def _map_names(choice: Choice) -> list[str]:
    """Return the maps of a scene's first view by name: which of them there are decides the blueprint."""
    return [one.name for one in view_maps(choice.views[0], choice.following(0))[0]]


def _blueprint(names: Sequence[str]) -> Any:
    """Return the layout: the world beside the picture with boxes and keypoints, and a tab for each map."""
    from rerun import blueprint  # pyright: ignore[reportMissingImports]

    def picture(eye: Eye) -> Any:
        shapes = ("picture", "boxes", "amodal", "keypoints")
        contents = [f"$origin/{name}/**" for name in shapes]
        return blueprint.Spatial2DView(origin=f"world/{eye}", contents=contents, name=f"{eye} picture")

    maps = []
    for name in names:
        eye, _, title = name.partition("/")
        contents = [f"world/{eye}/{title}/**"]
        maps.append(blueprint.Spatial2DView(origin=f"world/{eye}", contents=contents, name=name))
    world = blueprint.Spatial3DView(
        origin="world",
        name="world",
        contents=["$origin/**", *(f"- world/{name}/**" for name in names)],
    )
    pictures = blueprint.Tabs(*(picture(eye) for eye in EYES), name="pictures")
    layout_ = blueprint.Horizontal(world, blueprint.Vertical(pictures, blueprint.Tabs(*maps, name="labels")))
    return blueprint.Blueprint(layout_, collapse_panels=True)


def _log_scene(rr: ModuleType, recording: Any, scene: Scene) -> None:
    """Log the table and the objects: poses, surfaces, boxes."""
    _log_mesh(rr, recording, "world/table", scene.table.mesh, (*id_colour(TABLE_ID), 255))
    for item in scene.objects:
        entity, colour = f"world/objects/{item.name}", id_colour(item.id)
        pose = np.asarray(item.world_T_object)
        recording.log(entity, rr.Transform3D(translation=pose[:3, 3], mat3x3=pose[:3, :3]))
        box = rr.Boxes3D(
            half_sizes=[np.asarray(item.size) / 2],
            colors=[colour],
            labels=[f"{item.id} {item.category}"],
            fill_mode="majorwireframe",
        )
        recording.log(f"{entity}/box", box)
        if isinstance(item, Prop):
            _log_mesh(rr, recording, f"{entity}/surface", item.mesh, (*colour, 255))
            continue
        for number, interface in enumerate(item.interfaces):
            alpha = 255 if interface.opaque is not None else _GLASS
            _log_mesh(rr, recording, f"{entity}/{interface.part}-{number}", interface.mesh, (*colour, alpha))


def _classes(choices: Sequence[Choice]) -> list[_Class]:
    """Return number, name and colour of each id; one that means other objects in other scenes is named by its number.

    Rerun takes the colours of segmentations from contexts that do not change with time.
    """
    names: dict[int, set[str]] = {}
    for choice in choices:
        for item in choice.scene.objects().objects:
            names.setdefault(item.id, set()).add(item.name)
    classes = [(0, "nothing", NOTHING), (TABLE_ID, "table", id_colour(TABLE_ID))]
    for number, found in sorted(names.items()):
        classes.append((number, found.pop() if len(found) == 1 else f"object {number}", id_colour(number)))
    return classes


def _log_mesh(rr: ModuleType, recording: Any, entity: str, mesh: Any, colour: tuple[int, ...]) -> None:
    vertices, faces = simplified(mesh, MOST_TRIANGLES)
    recording.log(entity, rr.Mesh3D(vertex_positions=vertices, triangle_indices=faces, albedo_factor=colour))


def _log_view(
    rr: ModuleType,
    recording: Any,
    view: StoredView,
    following: StoredView | None,
    width: int,
    classes: list[_Class],
) -> None:
    """Log both cameras of a view, their pictures and maps, and the cloud of what the left one sees."""
    camera = view.camera()
    shown = min(width, camera.width)
    scale, height = shown / camera.width, max(1, round(camera.height * shown / camera.width))
    for eye in EYES:
        entity = f"world/{eye}"
        pose = camera.world_T_camera if eye == "left" else camera.world_T_right
        recording.log(entity, rr.Transform3D(translation=pose[:3, 3], mat3x3=pose[:3, :3]))
        recording.log(entity, _pinhole(rr, camera, scale, shown, height))
        picture = view.picture(eye)
        if picture.shape[:2] != (height, shown):
            picture = cv2.resize(picture, (shown, height), interpolation=cv2.INTER_AREA)
        recording.log(f"{entity}/picture", rr.Image(picture).compress(jpeg_quality=92))
        if eye == "left" or (view.folder / layout.RIGHT_LABELS).is_file():
            _log_labels(rr, recording, entity, view.labels(eye), scale)
    for one in view_maps(view, following)[0]:
        if one.kind == "ids":  # a view of one map knows only what is logged at the map itself
            recording.log(f"world/{one.name}", rr.AnnotationContext(classes), static=True)
        _log_map(rr, recording, one, reduced(one, shown, height))
    _log_infrared(rr, recording, view)
    points, colours, ids = view_points(view, camera)
    cloud = rr.Points3D(points, colors=colours, radii=_POINT, class_ids=ids)
    recording.log("world/cloud", cloud)


def _log_infrared(rr: ModuleType, recording: Any, view: StoredView) -> None:
    """Log the infrared pictures of a depth camera, each with its camera."""
    device, pictures = view.depth_camera(), infrared_pictures(view)
    if device is None:
        return
    for name, camera_T_infrared in (("left", device.camera_T_left), ("right", device.camera_T_right)):
        picture = pictures.get(f"infrared {name}")
        if picture is None or camera_T_infrared is None:
            continue
        entity, pose = f"world/infrared_{name}", view.camera().world_T_camera @ camera_T_infrared
        K = np.array(device.K) + np.array([[0.0, 0.0, 0.5], [0.0, 0.0, 0.5], [0.0, 0.0, 0.0]])
        recording.log(entity, rr.Transform3D(translation=pose[:3, 3], mat3x3=pose[:3, :3]))
        size = [device.width, device.height]
        pinhole = rr.Pinhole(image_from_camera=K, resolution=size, camera_xyz=rr.ViewCoordinates.RDF)
        recording.log(entity, pinhole)
        recording.log(f"{entity}/picture", rr.Image(picture, color_model="L"))


def _pinhole(rr: ModuleType, camera: Camera, scale: float, width: int, height: int) -> Any:
    """Return the intrinsics for a picture of another size; Rerun counts from the corner of the first pixel."""
    K = camera.K * scale
    K[:2, 2] = (camera.K[:2, 2] + 0.5) * scale
    K[2, 2] = 1.0
    return rr.Pinhole(
        image_from_camera=K,
        resolution=[width, height],
        camera_xyz=rr.ViewCoordinates.RDF,
        image_plane_distance=_PYRAMID,
    )


def _log_labels(rr: ModuleType, recording: Any, entity: str, labels: Labels, scale: float) -> None:
    """Log the boxes and keypoints of one eye in its picture."""
    for name in ("modal", "amodal"):
        found = [(label.id, getattr(label.box2d, name)) for label in labels.objects]
        boxes = [(number, (np.array(box) + 0.5) * scale) for number, box in found if box is not None]
        places = np.array([box for _, box in boxes]).reshape(-1, 4)
        colours = [id_colour(number) for number, _ in boxes]
        drawn = rr.Boxes2D(array=places, array_format=rr.Box2DFormat.XYXY, colors=colours)
        recording.log(f"{entity}/{'boxes' if name == 'modal' else name}", drawn)
    points = [point for label in labels.objects for point in label.keypoints if point.pixel is not None]
    pixels = (np.array([point.pixel for point in points]).reshape(-1, 2) + 0.5) * scale
    colours = [_STATES[point.state] for point in points]
    recording.log(f"{entity}/keypoints", rr.Points2D(pixels, colors=colours, radii=3.0))


def _log_map(rr: ModuleType, recording: Any, one: LabelMap, values: np.ndarray) -> None:
    """Log a map under its name: ids and classes as segmentations, depths as depths, others as pictures."""
    entity = f"world/{one.name}"
    if one.kind in ("class", "bits"):
        names = [name for name, _ in one.names]
        if one.kind == "bits":
            names = [
                "none",
                *("+".join(n for i, n in enumerate(names) if code >> i & 1) for code in range(1, 1 << len(names))),
            ]
        recording.log(entity, rr.AnnotationContext(list(enumerate(names))), static=True)
    if one.kind in ("ids", "class", "bits"):
        recording.log(entity, rr.SegmentationImage(values))
    elif one.kind == "number" and one.unit == "m":
        recording.log(entity, rr.DepthImage(values, meter=1.0 / one.step))
    elif one.kind == "number":
        recording.log(entity, rr.Image((values * one.step).astype(np.float32), color_model="L"))
    else:
        recording.log(entity, rr.Image(_colours(one, values)))


def _colours(one: LabelMap, values: np.ndarray) -> np.ndarray:
    """Return directions, flow, signed numbers and angles as colours, as `maps.js` has them, (H, W, 3) uint8."""
    if one.kind == "signed":
        return difference_colours(np.where(values == one.none, np.nan, values * one.step), one.high)
    if one.kind == "angle":
        return hue_colours(values[..., 0] * one.step / 180.0, srgb_curve(values[..., 1] / 255.0))
    if one.kind == "vector":
        colours = 127.5 + values * np.array([1.0, -1.0, -1.0])
        return np.where((values == 0).all(axis=-1, keepdims=True), 45, colours).clip(0, 255).astype(np.uint8)
    if one.kind == "flow":
        flow = values.astype(np.float64) * one.step
        turn = np.arctan2(flow[..., 1], flow[..., 0])[..., None] - 2.0944 * np.arange(3)
        full = np.minimum(np.linalg.norm(flow, axis=-1, keepdims=True) / one.high, 1.0)
        colours = 255.0 * (1.0 - full * (0.5 - 0.5 * np.cos(turn)))
        return np.where(values[..., :1] == one.none, 45, colours).astype(np.uint8)
    return values
