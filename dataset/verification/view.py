"""All checks of a stored view.

Each label is compared with what follows from the scene's description and its meshes, or from other files of the view.
A check is left out where a file that it reads has a fault already: one wrong label is then one fault.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ...core.json_file import read_record
from ...core.randomness import stream
from ...procedural.description.camera import Camera
from ...procedural.description.scene import Scene
from ...render.frame import EYES, Eye, Geometry, Layers
from ..format import layout
from ..format.camera_file import CAMERA_SCHEMA, CameraFile
from ..format.exr import read_channel
from ..format.map_files import read_pair
from ..format.matte_files import read_mattes
from ..format.objects_file import ObjectsFile
from ..stored_view import StoredView
from . import layers as layer_checks
from . import maps, mattes, objects, pictures, polarisation, refraction, sensors, surfaces
from .description import camera_faults
from .fault import Fault
from .pinhole import Pinhole, pinhole_of
from .triangles import Triangles, opaque_ids
from .truth import Truth, truth_of

#: Files of one eye's labels: labels, geometry, ids.
_FILES: dict[Eye, tuple[str, str, str]] = {
    "left": (layout.LABELS, layout.GEOMETRY, layout.INSTANCES),
    "right": (layout.RIGHT_LABELS, layout.RIGHT_GEOMETRY, layout.RIGHT_INSTANCES),
}


@dataclass
class ViewChecks:
    """The checks of one view, and what they found so far.

    Parameters
    ----------
    view : StoredView
        The view.
    scene : Scene
        The description.
    records : ObjectsFile
        ``objects.json``.
    triangles : Triangles or None
        The scene's surfaces; None for the quick checks alone, which compare files with each other.
    developed : bool
        Whether a camera with noise and processing took the pictures.
    """

    view: StoredView
    scene: Scene
    records: ObjectsFile
    triangles: Triangles | None
    developed: bool = False
    faults: list[Fault] = field(default_factory=list)
    wrong: set[str] = field(default_factory=set)  #: what has a fault

    def run(self) -> list[Fault]:
        """Run all checks, and return what they found."""
        record = read_record(CameraFile, self.view.folder / layout.CAMERA, CAMERA_SCHEMA)
        self._check("camera", (), lambda: camera_faults(self._camera, record, layout.CAMERA))
        self._check("pictures", (), lambda: pictures.picture_faults(self.view, self._pinhole("left")))
        self._check("radiance", ("pictures",), self._radiance)
        for eye in EYES:
            if eye == "left" or self._has(layout.RIGHT_LABELS):
                self._eye(eye)
        if self._has(layout.LAYERS):
            self._layers()
        if self._has(layout.REFRACTION):
            self._refraction()
        self._check("sensor", ("depth", "ids"), self._sensor)
        self._check("polarisation", ("ids", "radiance"), self._polarisation)
        self._maps()
        if self._has(layout.MATTES):
            self._mattes()
        return self.faults

    def _check(self, subject: str, needs: tuple[str, ...], check: Callable[[], list[Fault]]) -> None:
        if not self.wrong.intersection(needs):
            found = check()
            if found:
                self.wrong.add(subject)
                self.faults += found

    def _radiance(self) -> list[Fault]:
        faults = pictures.radiance_faults(self.view, self.scene, self.developed)
        return faults or pictures.sensor_faults(self.view, self.scene)

    def _has(self, name: str) -> bool:
        return (self.view.folder / name).is_file()

    @property
    def _camera(self) -> Camera:
        return self.scene.cameras[self.view.number]

    def _pinhole(self, eye: Eye) -> Pinhole:
        return pinhole_of(self._camera, eye)

    @cached_property
    def _keypoints(self) -> list[np.ndarray]:
        return [np.array(record.keypoints).reshape(-1, 3) for record in self.records.objects]

    @cached_property
    def _geometry(self) -> dict[Eye, Geometry]:
        found: dict[Eye, Geometry] = {"left": self.view.geometry()}
        if self._has(layout.RIGHT_LABELS):
            found["right"] = self.view.geometry("right")
        return found

    @cached_property
    def _left_truth(self) -> Truth | None:
        return None if self.triangles is None else truth_of(self.triangles, self._pinhole("left"))

    @cached_property
    def _stored_layers(self) -> Layers:
        return self.view.layers()

    def _eye(self, eye: Eye) -> None:
        labels, (file, geometry_file, ids_file) = self.view.labels(eye), _FILES[eye]
        camera, scene = self._pinhole(eye), self.scene
        name = "" if eye == "left" else "right "
        self._check(f"{name}objects", (), lambda: objects.object_list_faults(scene, labels, file))
        if f"{name}objects" in self.wrong:
            return  # all others go through objects and labels in pairs
        geometry = self._geometry[eye]
        depth, ids, background, normals, masks, counts = (
            f"{name}{what}" for what in ("depth", "ids", "background", "normals", "masks", "counts")
        )
        if self.triangles is not None:
            self._against_meshes(eye, geometry)
        checks = (
            (ids, (depth,), lambda: surfaces.id_contradictions(scene, geometry, ids_file)),
            (background, (depth, ids), lambda: surfaces.background_contradictions(scene, geometry, geometry_file)),
            (
                f"{name}transmittance",
                (ids, background),
                lambda: surfaces.transmittance_faults(scene, geometry, geometry_file),
            ),
            (normals, (depth,), lambda: surfaces.normal_contradictions(camera, geometry, geometry_file)),
            (masks, (ids,), lambda: surfaces.silhouette_contradictions(scene, geometry, file)),
            (f"{name}poses", (), lambda: objects.pose_faults(scene, camera, labels, file)),
            (f"{name}boxes", (), lambda: objects.amodal_box_faults(scene, camera, labels, file)),
            (f"{name}boxes", (ids,), lambda: objects.modal_box_faults(labels, geometry, file)),
            (counts, (ids, masks), lambda: objects.count_faults(labels, geometry, file)),
            (f"{name}fractions", (counts, ids, masks), lambda: objects.fraction_faults(labels, file)),
            (f"{name}occlusion", (ids, masks), lambda: objects.order_faults(labels, geometry, file)),
            (
                f"{name}keypoints",
                ("object points",),
                lambda: objects.keypoint_faults(self._keypoints, scene, camera, labels, file),
            ),
        )
        for subject, needs, check in checks:
            self._check(subject, needs, check)

    def _against_meshes(self, eye: Eye, geometry: Geometry) -> None:
        file, geometry_file, ids_file = _FILES[eye]
        triangles, scene, camera = self.triangles, self.scene, self._pinhole(eye)
        assert triangles is not None
        truth = self._left_truth if eye == "left" else truth_of(triangles, camera)
        assert truth is not None
        name = "" if eye == "left" else "right "
        labels = self.view.labels(eye)
        checks = (
            ("depth", lambda: surfaces.depth_faults(truth, geometry, geometry_file)),
            ("ids", lambda: surfaces.id_faults(truth, triangles, geometry, ids_file)),
            ("background", lambda: surfaces.background_faults(truth, triangles, geometry, geometry_file)),
            ("normals", lambda: surfaces.normal_faults(truth, triangles, geometry, geometry_file)),
            ("masks", lambda: surfaces.mask_faults(truth, triangles, scene, geometry, file)),
            (
                "keypoints",
                lambda: objects.keypoint_state_faults(triangles, self._keypoints, scene, camera, labels, file),
            ),
        )
        for subject, check in checks:
            needs = ("object points",) if subject == "keypoints" else ()
            self._check(name + subject, needs, check)

    def _layers(self) -> None:
        layers, geometry, file = self._stored_layers, self._geometry["left"], layout.LAYERS
        truth, triangles = self._left_truth, self.triangles
        if truth is not None and triangles is not None:
            self._check("layers", (), lambda: layer_checks.layer_faults(truth, triangles, self.scene, layers, file))
        needs = ("layers", "depth", "ids")
        self._check("layers", needs, lambda: layer_checks.layer_contradictions(layers, geometry, file))
        self._check("layers", ("layers",), lambda: layer_checks.alternation_faults(self.scene, layers, file))

    def _refraction(self) -> None:
        rays, camera, triangles = self.view.refraction(), self._pinhole("left"), self.triangles
        opaque = opaque_ids(self.scene)
        file = layout.REFRACTION
        self._check("refraction", (), lambda: refraction.refraction_contradictions(rays, camera, opaque, file))
        if triangles is not None:
            self._check(
                "refraction",
                ("refraction",),
                lambda: refraction.refraction_faults(rays, camera, triangles, self._stream("refraction"), file),
            )

    def _sensor(self) -> list[Fault]:
        return sensors.sensor_faults(self.view, self.scene.depth_camera, self._geometry["left"])

    def _polarisation(self) -> list[Fault]:
        return polarisation.polarisation_faults(self.view, self.scene, self._geometry["left"])

    def _maps(self) -> None:
        folder, geometry, scene = self.view.folder, self._geometry, self.scene
        camera, pinhole = self._camera, self._pinhole("left")
        depths = ("depth", "background", "right depth", "right background")
        if self._has(layout.DISPARITY):
            path = folder / layout.DISPARITY
            self._check("disparity", depths, lambda: maps.disparity_faults(path, camera, geometry))
        if self._has(layout.PAIR):
            pair = folder / layout.PAIR
            self._check(
                "pair", depths, lambda: maps.pair_contradictions(pair, camera, geometry, lambda e: read_pair(pair, e))
            )
            if self.triangles is not None:
                triangles, rng = self.triangles, self._stream("pair")
                self._check(
                    "pair",
                    ("pair", *depths),
                    lambda: maps.pair_faults(pair, camera, triangles, geometry, lambda e: read_pair(pair, e), rng),
                )
        if self._has(layout.HEATMAP):
            ids, labels = geometry["left"].id, self.view.labels()
            self._check("heatmap", ("ids", "poses"), lambda: maps.heatmap_faults(folder / layout.HEATMAP, ids, labels))
        layers = self._stored_layers if self._has(layout.LAYERS) and "layers" not in self.wrong else None
        if self._has(layout.COORDINATES):
            path = folder / layout.COORDINATES
            seen = geometry["left"]
            self._check(
                "coordinates", ("depth", "ids"), lambda: maps.coordinate_faults(path, scene, pinhole, seen, layers)
            )
        if self._has(layout.VESSEL_PARTS) and layers is not None:
            lines = [
                [np.array(line) for line in record.openings]
                for record in self.records.objects
                if record.material.kind == "glass"
            ]
            mouths = maps.mouth_masks(scene, pinhole, lines)
            path = folder / layout.VESSEL_PARTS
            self._check(
                "vessel parts",
                ("object points",),
                lambda: maps.part_faults(path, scene, geometry["left"], layers, mouths),
            )

    def _mattes(self) -> None:
        path, geometry = self.view.folder / layout.MATTES, self._geometry["left"]
        stored, total = read_mattes(self.view.folder, self.records.objects), read_channel(path, "A")
        needs = ("ids", "masks", "background", "transmittance")
        self._check("mattes", needs, lambda: mattes.matte_contradictions(stored, total, geometry))
        self._check(
            "cryptomatte", ("mattes", *needs), lambda: mattes.cryptomatte_contradictions(stored, total, geometry)
        )
        if self.triangles is not None:
            camera, triangles, rng = self._pinhole("left"), self.triangles, self._stream("mattes")
            self._check("mattes", ("mattes",), lambda: mattes.matte_faults(stored, camera, triangles, rng))

    def _stream(self, name: str) -> np.random.Generator:
        return stream(self.scene.seed, self.scene.scene_id, f"verify/{self.view.number}/{name}")
