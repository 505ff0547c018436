"""The pictures of a view as a colour camera takes them, with the record of that camera."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...annotate.labels import Rle
from ...annotate.masks import encode_mask
from ...core.json_file import json_text
from ...core.margin import NO_MARGIN, Sides
from ...procedural.description.camera import Camera
from ...procedural.description.scene import Scene
from ...procedural.scene.settings import SceneSettings
from ..cameras.develop import PairLight, develop, lost_pixels, rendered_margin
from ..cameras.lens import Lens, check_distortion
from ..cameras.model import SensorColour
from ..cameras.presets import CAMERAS
from . import layout
from .camera_file import DepthCameraRecord, PolarisationRecord, camera_file
from .dataset_file import Development
from .pictures import write_png


def write_developed(
    folder: Path,
    camera: Camera,
    pair: tuple[np.ndarray, np.ndarray],
    Z: np.ndarray,
    development: Development,
    place: tuple[int, int],
    depth_camera: DepthCameraRecord | None = None,
    polarisation_camera: PolarisationRecord | None = None,
    margin: Sides = NO_MARGIN,
    sensor: SensorColour | None = None,
) -> np.ndarray:
    """Write ``left.png``, ``right.png`` and ``camera.json`` of a view into its folder; return the left picture.

    Parameters
    ----------
    folder : Path
        The view's folder.
    camera : Camera
        The stereo pair.
    pair : two (H, W, 3) float32
        Radiance of the left and the right camera, linear Rec.709, or the raw response of `sensor`.
    Z : (H, W) float32
        Planar depth of the first surface of the left camera [m].
    development : Development
        The colour camera, and the seed of its errors and noise.
    place : (int, int)
        Numbers of scene and view: those of the random streams.
    depth_camera : DepthCameraRecord, optional
        The depth camera beside the left one.
    polarisation_camera : PolarisationRecord, optional
        The polarisation camera in its place.
    margin : Sides
        What `pair` and `Z` have beyond the frame of H x W pixels, for the distortion of the lens.
    sensor : SensorColour, optional
        The sensor of measured sensitivities.
    """
    optics = optics_of(camera)
    light = PairLight(*pair, Z, optics, camera.baseline, camera.exposure, camera.tone, margin, sensor)
    left, right = develop(development.camera, light, development.seed, *place)
    write_png(folder / "left.png", left)
    write_png(folder / "right.png", right)
    lost = lost_pixels(development.camera, optics, camera.width, camera.height, margin)
    lens = development.camera
    record = camera_file(camera).model_copy(
        update={
            "colour_camera": None if lens.ideal else lens.name,
            "distortion": "none" if lens.rectified or lens.distortion.absent else lens.distortion,
            "sensitivities": sensor,
            "depth_camera": depth_camera,
            "polarisation_camera": polarisation_camera,
            "lost": None if lost is None else Rle(size=(camera.height, camera.width), counts=encode_mask(lost)),
        }
    )
    (folder / layout.CAMERA).write_text(json_text(record.model_dump(mode="json")), encoding="utf-8")
    return left


def development_of(scene: Scene) -> Development:
    """Return the camera that a scene's pictures are built with, and its seed."""
    return Development(camera=CAMERAS[scene.picture.camera], seed=scene.seed)


def margin_of(scene: Scene, view: int) -> Sides:
    """Return what has to be rendered beyond the frame of a view for the lens of the camera that it is built with."""
    camera = scene.cameras[view]
    return rendered_margin(development_of(scene).camera, optics_of(camera), camera.width, camera.height)


def check_camera(settings: SceneSettings) -> None:
    """Raise InputError where the distortion of the camera of new pictures folds over inside them."""
    pixels = settings.cameras.intrinsics()
    optics = (pixels.fx, pixels.fy, pixels.cx, pixels.cy)
    lens = CAMERAS[settings.picture.camera].distortion
    check_distortion(lens, optics, pixels.width, pixels.height, f"picture.camera {settings.picture.camera}")


def optics_of(camera: Camera) -> Lens:
    """Return focal lengths and principal point of a stereo pair [px]."""
    return camera.fx, camera.fy, *camera.centre
