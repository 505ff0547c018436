"""A stored view: its files as the typed data that they were written from, and labels that follow from them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, cast, get_args

import numpy as np

from ..annotate.coordinates import back_wall, object_coordinates
from ..annotate.flow import flow_visibility, optical_flow
from ..annotate.heatmap import view_heatmap
from ..annotate.labels import LABELS_SCHEMA, Labels
from ..annotate.masks import decode_mask
from ..annotate.mattes import Mattes
from ..annotate.outlines import fill_lines, openings
from ..annotate.projection import disparity, project, transformed, unproject
from ..annotate.stereo import PairVisibility
from ..annotate.vessel_parts import VesselParts
from ..core.arguments import check_type, one_of, whole_number
from ..core.errors import InputError
from ..core.json_file import check_schema, parsed, read_json, read_record
from ..core.randomness import MOST_SEED, stream
from ..procedural.description.camera import Camera
from ..procedural.description.depth_camera import DepthCamera
from ..procedural.description.scene import Scene, SceneObject
from ..procedural.scene.scene_file import load_scene
from ..procedural.sensors.depth_cameras import depth_camera
from ..render.frame import EYES, Eye, Geometry, Layers, Refraction, StokesPicture
from .depth_cameras.from_labels import painted
from .format import layout
from .format.camera_file import CAMERA_SCHEMA, CameraFile, DepthCameraRecord, PolarisationRecord, camera_of, known_K
from .format.exr import channel, exr_channels, read_channel, read_exr, stacked
from .format.file_kinds import FileKind
from .format.map_files import parts_of, read_coordinates, read_disparity, read_ids, read_pair
from .format.matte_files import read_mattes
from .format.objects_file import OBJECTS_SCHEMA, ObjectsFile
from .format.partial_labels import PARTIAL_LABELS_SCHEMA, PartialLabels
from .format.pictures import read_png
from .format.polarisation_files import read_stokes
from .format.raw_files import read_raw
from .format.ray_files import read_layers, read_refraction
from .format.sensor_files import IR_FILES, read_numbers, read_sensor_depth
from .polarisation_cameras.mosaic import signal_of, stokes_of_mosaic

_Frame = Literal["camera", "world"]


@dataclass(frozen=True)
class StoredView:
    """A view on disk; each call reads its files."""

    folder: Path
    number: int

    def camera(self) -> Camera:
        """Return the stereo pair; InputError where a converted data set has one camera, or no calibration."""
        return camera_of(self.camera_record(), self.folder / layout.CAMERA)

    def camera_record(self) -> CameraFile:
        """Return the file of the cameras as it is; in converted data sets it says what is unknown."""
        return read_record(CameraFile, self.folder / layout.CAMERA, CAMERA_SCHEMA)

    def scene(self) -> Scene:
        """Return the whole description of the view's scene."""
        return load_scene(self.folder.parent / layout.SCENE)

    def labels(self, eye: Eye = "left") -> Labels:
        """Return the labels of one camera, in its own frame; those of the right one need ``--write right-labels``."""
        path = self.folder / layout.LABELS if _checked_eye(eye) == "left" else self._right(layout.RIGHT_LABELS)
        data = read_json(path)
        if isinstance(data, dict) and data.get("schema_version") == PARTIAL_LABELS_SCHEMA:
            expected = "the labels of a rendered view"
            raise InputError(path, expected, "those of a converted data set, which partial_labels() reads")
        check_schema(path, data, LABELS_SCHEMA)
        return parsed(Labels, data, path)

    def partial_labels(self) -> PartialLabels:
        """Return the labels of a view of a converted data set: what that states, and None for the rest."""
        return read_record(PartialLabels, self.folder / layout.LABELS, PARTIAL_LABELS_SCHEMA)

    def has_depth(self) -> bool:
        """Return whether true depth is stored; converted data sets may have none, or normals alone."""
        path = self.folder / layout.GEOMETRY
        return path.is_file() and "Z" in exr_channels(path)

    def depth(self) -> np.ndarray:
        """Return the true planar depth of the first surface, (H, W) float32 [m].

        It is +inf where there is none, and in converted data sets NaN where it is unknown.
        """
        return read_channel(self._stored(layout.GEOMETRY, "depth"), "Z")

    def instances(self) -> np.ndarray:
        """Return the instance ids of the first surface, (H, W) uint16; 0 is nothing, or what no label names."""
        return read_ids(self._stored(layout.INSTANCES, "instances"))

    def classes(self) -> np.ndarray:
        """Return the classes of pixels, (H, W) uint16, which ``converted.classes`` of the data set's head names."""
        return read_ids(self._stored(layout.CLASSES, "classes of pixels"))

    def picture(self, eye: Eye = "left") -> np.ndarray:
        """Return the 8-bit sRGB picture, (H, W, 3) uint8."""
        return read_png(self.folder / f"{_checked_eye(eye)}.png")

    def radiance(self, eye: Eye = "left", noisy: bool = False) -> np.ndarray:
        """Return linear Rec.709 radiance, (H, W, 3) float32; ``noisy`` is before the denoiser."""
        path, kind = self._of_kind(f"{_checked_eye(eye)}.exr", "noisy" if noisy else "radiance")
        channels = read_exr(path)
        if ("noisy.R" if noisy else "R") not in channels:
            raise _absent(path, kind)
        return stacked(channels, "noisy.RGB" if noisy else "RGB", path).astype(np.float32, copy=False)

    def raw(self, eye: Eye = "left") -> np.ndarray:
        """Return what the camera's sensor makes of the light, (H, W, 3) float32: raw red, green and blue.

        It needs the setting `sensors.sensitivities` and ``--write radiance``.
        """
        return read_raw(self.folder, _checked_eye(eye), self.camera_record().sensitivities)

    def geometry(self, eye: Eye = "left") -> Geometry:
        """Return the geometry of one camera; the silhouettes come from the masks of its labels.

        That of the right camera needs ``--write right-labels``.
        """
        if _checked_eye(eye) == "left":
            path, instances = self.folder / layout.GEOMETRY, self.folder / layout.INSTANCES
        else:
            path, instances = self._right(layout.RIGHT_GEOMETRY), self._right(layout.RIGHT_INSTANCES)
        channels = read_exr(path)
        ids = read_ids(instances)
        Z = channel(channels, "Z", path)
        if ids.shape != Z.shape:
            raise InputError(instances, f"16-bit ids of {Z.shape} px", ids.shape)
        return Geometry(
            Z=Z,
            normal=stacked(channels, "N.XYZ", path).astype(np.float32, copy=False),
            id=ids,
            background_Z=channel(channels, "background.Z", path),
            background_id=channel(channels, "background.id", path).astype(np.uint16),
            transmittance=stacked(channels, "transmittance.RGB", path).astype(np.float32, copy=False),
            crossed=self._masks(eye, "mask_amodal", Z.shape),
            reached=self._masks(eye, "mask_seen", Z.shape),
        )

    def layers(self) -> Layers:
        """Return the surfaces along the left camera's straight rays, as many layers as the file has."""
        return read_layers(self._of_kind(layout.LAYERS, "layers")[0])

    def refraction(self) -> Refraction:
        """Return the end points of the left camera's refracted rays."""
        return read_refraction(self._of_kind(layout.REFRACTION, "refraction")[0])

    def points(self, frame: _Frame = "camera") -> np.ndarray:
        """Return the point cloud of the first surfaces that the left camera sees, glass included.

        Parameters
        ----------
        frame : {"camera", "world"}
            Frame of the points: the left camera's (OpenCV axes), or the world's.

        Returns
        -------
        (n, 3) float64
            One point per pixel that sees a surface, row by row [m].
        """
        one_of("frame", frame, get_args(_Frame))
        camera = self.camera_record()
        seen = unproject(self.depth(), np.array(known_K(camera, self.folder / layout.CAMERA)))
        points = seen[np.isfinite(seen[..., 2])]
        return points if frame == "camera" else transformed(camera.world_T_camera, points)

    def disparity(self, eye: Eye = "left", background: bool = False) -> np.ndarray:
        """Return the disparity ``f b / Z`` of the first surface, or of the first opaque one, (H, W) float32 [px].

        It is 0 where there is no surface. That of the left camera follows from its depth; that of the right one needs
        ``--write right-labels`` or ``disparity``.
        """
        stored = self.folder / layout.DISPARITY
        if _checked_eye(eye) == "right" and stored.is_file():
            return read_disparity(stored, eye, background)
        path = self.folder / layout.GEOMETRY
        if eye == "right":
            path = self.folder / layout.RIGHT_GEOMETRY
            if not path.is_file():
                raise _absent(stored, "disparity")
        name, camera = "background.Z" if background else "Z", self.camera()
        Z = read_channel(path, name)
        return disparity(Z, camera.fx, camera.baseline).astype(np.float32)

    def pair_visibility(self, eye: Eye = "left") -> PairVisibility:
        """Return how the other camera sees the points of one; it needs ``--write disparity``."""
        return read_pair(self._of_kind(layout.PAIR, "disparity")[0], _checked_eye(eye))

    def depth_camera(self) -> DepthCameraRecord | None:
        """Return the depth camera beside the left colour camera: unit, range, place; None where there is none."""
        return self.camera_record().depth_camera

    def sensor_depth(self) -> np.ndarray:
        """Return the depth that a depth camera reports in the left picture's pixels, (H, W) float32 [m]; NaN: none.

        It needs a data set made with the setting `sensors.depth`, or a converted one that has it.
        """
        measured = self.folder / layout.MEASURED_DEPTH
        if measured.is_file():
            return read_channel(measured, "Z")
        return read_sensor_depth(self.folder / layout.SENSOR_DEPTH, self._sensor().unit)

    def sensor_valid(self) -> np.ndarray:
        """Return why each pixel has a sensor depth or none, (H, W) uint16: places in `depth_camera().reasons`."""
        self._sensor()
        return read_numbers(self.folder / layout.SENSOR_VALID)

    def infrared(self, eye: Eye = "left") -> np.ndarray:
        """Return an infrared picture of the depth camera, (h, w) uint16; it needs ``--write infrared``."""
        device = self._sensor()
        if device.kind != "stereo":
            raise InputError(self.folder / layout.CAMERA, "a stereo camera, such as sensors.depth d435", device.name)
        return read_numbers(self._of_kind(IR_FILES[_checked_eye(eye)], "infrared")[0])

    def polarisation_camera(self) -> PolarisationRecord | None:
        """Return the polarisation camera of the view: filters, bits, gain; None where there is none."""
        return self.camera_record().polarisation_camera

    def stokes(self) -> StokesPicture:
        """Return the Stokes vectors that the left camera sees, with their errors.

        It needs a data set made with the setting `sensors.polarisation`.
        """
        self._polarisation()
        return read_stokes(self.folder / layout.STOKES)

    def polarisation_mosaic(self) -> np.ndarray:
        """Return what a polarisation camera reports, (H, W) uint16: a filter on each pixel (docs/polarisation.md)."""
        self._polarisation()
        return read_numbers(self.folder / layout.MOSAIC)

    def measured_stokes(self) -> np.ndarray:
        """Return the Stokes vectors that follow from the mosaic, (H, W, 3, n) float32: s0, s1, s2 as radiance.

        A camera in colour has three channels, others have one. They have the camera's noise, and at edges they are
        wrong: the four filters of a cell see different places.
        """
        device = self._polarisation()
        light = signal_of(self.polarisation_mosaic(), device.bits, device.black_level) / np.float32(device.gain)
        return stokes_of_mosaic(device, light)

    def _polarisation(self) -> PolarisationRecord:
        device = self.polarisation_camera()
        if device is None:
            expected = "a data set with a polarisation camera, made with --sensors.polarisation imx250mzr"
            raise InputError(self.folder / layout.CAMERA, expected, "one without")
        return device

    def painted_sensor_depth(self, device: str = "d435", seed: int = 0) -> np.ndarray:
        """Return true depth with a depth camera's kinds of faults painted onto it, (H, W) float32 [m]; NaN for none.

        It needs no other rendering and takes milliseconds. Noise, shadows and patches on glass are drawn at random
        (`dataset.depth_cameras.from_labels`); what light and matching do on glass is in `sensor_depth`.

        Parameters
        ----------
        device : str
            A device by its name, or a YAML file (`sensors.depth`).
        seed : int
            Of the faults.
        """
        known, seed = depth_camera(device, "device"), whole_number("seed", seed, 0, MOST_SEED)
        if not isinstance(known, DepthCamera):
            raise InputError("device", "a stereo depth camera, such as d435", device)
        records = read_record(ObjectsFile, self.folder.parent / layout.OBJECTS, OBJECTS_SCHEMA)
        geometry = self.geometry()
        glass = np.isin(geometry.id, [item.id for item in records.objects if item.material.kind == "glass"])
        rng = stream(seed, int(self.folder.parent.name), f"sensors/{self.number}/painted")
        return painted(known, self.camera(), geometry, glass, rng)[0]

    def _sensor(self) -> DepthCameraRecord:
        device = self.depth_camera()
        if device is None:
            expected = "a data set with a depth camera, made with --sensors.depth d435"
            raise InputError(self.folder / layout.CAMERA, expected, "one without")
        return device

    def heatmap(self) -> np.ndarray:
        """Return the heatmap of the left picture's objects, as the networks learn it, (H, W) float32 in [0, 1]."""
        return view_heatmap(read_ids(self.folder / layout.INSTANCES), self.labels().objects)

    def object_coordinates(self, back: bool = False) -> np.ndarray:
        """Return normalised object coordinates of the left picture, (H, W, 3) float32; NaN where there is no object.

        Parameters
        ----------
        back : bool
            Those of the last surface of the first surface's object along the ray, such as the back wall of a vessel,
            instead of the first surface's. It needs ``--write coordinates`` or ``layers``.
        """
        stored = self.folder / layout.COORDINATES
        if back and stored.is_file():
            return read_coordinates(stored, back)
        if back and not (self.folder / layout.LAYERS).is_file():
            raise _absent(stored, "coordinates")
        ids = read_ids(self.folder / layout.INSTANCES)
        Z = back_wall(self.layers(), ids) if back else self.depth()
        return object_coordinates(Z, ids, self.labels().objects, self.camera().K)

    def flow(self, other: StoredView) -> np.ndarray:
        """Return where the first surfaces of the left picture appear in that of another view of the scene.

        Returns
        -------
        (H, W, 2) float32
            (du, dv) to add to a pixel [px]; NaN where there is no surface, or it is behind the other camera.
        """
        return optical_flow(self.depth(), self.camera(), _same_scene(self, other).camera())

    def flow_visibility(self, other: StoredView) -> np.ndarray:
        """Return where another view shows the first surface of a pixel as its own first surface, (H, W) bool."""
        there = _same_scene(self, other)
        return flow_visibility(self.depth(), self.camera(), there.depth(), there.camera())

    def vessel_parts(self) -> dict[str, VesselParts]:
        """Return the masks of each vessel's parts in the left picture, by name; it needs ``--write layers``."""
        return parts_of(self.scene(), self.layers(), self.camera())

    def mattes(self) -> Mattes:
        """Return the soft mattes of the left picture's objects; they need ``--write mattes``."""
        self._of_kind(layout.MATTES, "mattes")
        path = self.folder.parent / layout.OBJECTS
        records = read_record(ObjectsFile, path, OBJECTS_SCHEMA).objects
        return read_mattes(self.folder, records)

    def openings(self) -> dict[str, tuple[np.ndarray, ...]]:
        """Return the mouths of vessels in the left picture as polygons, by name, each (n, 2) [px]."""
        return self._lines(openings)

    def fill_lines(self) -> dict[str, tuple[np.ndarray, ...]]:
        """Return where liquids meet the wall in the left picture as closed lines, by name, each (n, 2) [px]."""
        return self._lines(fill_lines)

    def _lines(self, lines_of: Callable[[SceneObject], tuple[np.ndarray, ...]]) -> dict[str, tuple[np.ndarray, ...]]:
        camera, found = self.camera(), {}
        for body in self.scene().vessels:
            world = (transformed(body.world_T_object, line) for line in lines_of(body))
            found[body.name] = tuple(project(line, camera.K, camera.world_T_camera)[0] for line in world)
        return found

    def _stored(self, name: str, what: str) -> Path:
        """Return a file that a converted data set may lack; InputError where it does."""
        path = self.folder / name
        if not path.is_file():
            raise InputError(path, f"a data set with {what}", f"one without {what}")
        return path

    def _of_kind(self, name: str, kind: FileKind) -> tuple[Path, FileKind]:
        """Return a file that is written on request, with its kind; InputError where it was not."""
        path = self.folder / name
        if not path.is_file():
            raise _absent(path, kind)
        return path, kind

    def _right(self, name: str) -> Path:
        return self._of_kind(name, "right-labels")[0]

    def _masks(self, eye: Eye, field: str, shape: tuple[int, ...]) -> np.ndarray:
        path = self.folder / (layout.LABELS if eye == "left" else layout.RIGHT_LABELS)
        masks = [np.zeros((0, *shape), bool)]
        for label in self.labels(eye).objects:
            rle = getattr(label, field)
            where = f"{path}: object {label.id} {field}"
            if rle.size != shape:
                raise InputError(where, f"size {shape}", rle.size)
            try:
                masks.append(decode_mask(rle.counts, rle.size)[None])
            except ValueError as error:
                raise InputError(where, "a mask", error) from error
        return np.concatenate(masks)


def _same_scene(view: StoredView, other: object) -> StoredView:
    check_type("other", other, StoredView, "another view of the same scene")
    there = cast(StoredView, other)
    if there.folder.parent.resolve() != view.folder.parent.resolve():
        raise InputError("other", f"a view of the same scene, {view.folder.parent}", there.folder.parent)
    return there


def _absent(path: Path, kind: FileKind) -> InputError:
    """Return the error of a file that a view may lack, with how it is made."""
    expected = f"a data set with {kind}, made with --write {kind} (from Python: files={kind!r})"
    return InputError(path, expected, f"one without {kind}")


def _checked_eye(eye: object) -> Eye:
    return cast(Eye, one_of("eye", eye, EYES))
