"""Multi-view samples of a data set, and batches of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import numpy as np
import torch
from torch import Tensor
from torch.utils.data import Dataset as TorchDataset

from ...core.errors import InputError
from ...core.randomness import stream
from ...dataset.format.camera_file import CameraFile
from ...dataset.format.objects_file import ObjectsFile
from ...dataset.reader import Dataset, Eye, StoredScene, StoredView
from ...procedural.description.scene import TABLE_ID
from ..targets.encoding import Encoding
from ..targets.view import view_targets
from .augment import augmented
from .geometric_augment import moved_pixels
from .ground_truth import GroundTruth, read_ground_truth, scene_surface_points
from .partial_truth import box_depths, check_learnable, read_partial_truth
from .scaling import fitted, fitted_K, scaled_depth, scaled_ground_truth, scaled_view
from .settings import AugmentSettings, ViewSettings
from .splits import SplitName, scenes_of
from .view_selection import LAST_REFERENCE, grid_neighbours, nearest_cameras
from .views import CameraView, check_colours, check_sides, check_sizes, read_camera, read_view
from .windows import Window, cut, cut_labels, stored_windows, windowed_K

#: Fractions of object pixels that are nearer than the first plane, and nearer than the last one.
DEPTH_QUANTILES = (0.005, 0.995)
#: Views from which the planes are taken, evenly spaced: about as many.
DEPTH_VIEWS = 64
#: A view's depths, by as many quantiles: at steps finer than `DEPTH_QUANTILES`.
_QUANTILES = np.linspace(0.0, 1.0, 1001)


@dataclass(frozen=True, eq=False)
class Sample:
    """Images of one scene from several cameras, and the targets of the first one (the reference)."""

    name: str  #: such as ``scenes/000003/004``, the folder of the reference view
    images: Tensor  #: (V, 3, H, W) float32 in [0, 1]
    world_T_camera: Tensor  #: (V, 4, 4) float32
    K: Tensor  #: (V, 3, 3) float32 [px]
    targets: dict[str, Tensor]  #: of `targets.view.view_targets`
    ground_truth: GroundTruth | None  #: the labels themselves; None unless `SampleDataset` was made with them


@dataclass(frozen=True, eq=False)
class LoadedViews:
    """The views of a sample, and the labels of the reference."""

    name: str
    views: tuple[CameraView, ...]  #: of one size; the reference first
    labels: GroundTruth
    sensor_depth: np.ndarray | None = None  #: (H, W) [m], 0 for none; of a data set with depth cameras, where asked for


class Samples(Protocol):
    """Samples by items (index, draw): of a view each, as in `SampleDataset`, or of an object each."""

    def __len__(self) -> int:
        """Return the number of indices."""
        ...

    def __getitem__(self, item: tuple[int, int]) -> Sample:
        """Return the sample of an item."""
        ...


class SampleDataset(TorchDataset):
    """Samples of a data set, one for each view that can be a reference.

    An item is (index, draw): the number of the reference, and the number of the random draw of source views and
    augmentation, such as the epoch. A sample depends on these two and the seed alone.

    Parameters
    ----------
    root : Path
        The data set.
    split : str
        ``train``, ``val``, ``test``, or ``all`` for every scene.
    views : ViewSettings
        Number, selection and size of the views.
    encoding : Encoding
        Encoding of the targets.
    augment : AugmentSettings, optional
        Image augmentation; none by default.
    seed : int
        Seed of the draws.
    ground_truth : bool
        Whether samples have their ground truth.
    sensor_depth : bool
        Whether `load` gives the depth of a depth camera, where the data set has one.

    Raises
    ------
    InputError
        Where data set or split does not exist, or has no view that can be a reference.
    """

    def __init__(
        self,
        root: Path,
        split: SplitName,
        views: ViewSettings,
        encoding: Encoding,
        *,
        augment: AugmentSettings | None = None,
        seed: int = 0,
        ground_truth: bool = False,
        sensor_depth: bool = False,
    ) -> None:
        if views.rule == "stereo" and views.count != 2:
            raise InputError("views.count", "2 with the rule stereo", views.count)
        if views.rule != "stereo" and views.convergence is not None:
            raise InputError("views.convergence", "the rule stereo", views.rule)
        self.root, self._views, self._encoding = root, views, encoding
        self._augment, self._seed, self._with_ground_truth = augment, seed, ground_truth
        self._with_sensor_depth = sensor_depth
        self._last_labels: tuple[int, GroundTruth] | None = None
        self._surface_of: dict[int, dict[int, np.ndarray]] = {}
        self._objects_of: dict[int, ObjectsFile] = {}
        self._cameras_of: dict[int, list[CameraFile]] = {}
        data = Dataset.open(root)
        self._converted = data.head.converted
        if self._converted is not None:
            check_learnable(root, self._converted, views.rule)
        scenes = scenes_of(data, split)
        self._references = [(scene, view) for scene in scenes for view in scene.views if self._can_be_reference(view)]
        if not self._references:
            raise InputError(f"{root}, split {split}", "a view that can be a reference", "none")

    def __len__(self) -> int:
        """Return the number of references."""
        return len(self._references)

    def __getitem__(self, item: tuple[int, int]) -> Sample:
        """Return the sample of an item (index, draw)."""
        loaded = self.load(item)
        targets = view_targets(
            loaded.labels.instances, loaded.labels.Z, loaded.labels.objects, loaded.views[0].K, self._encoding
        )
        return Sample(
            name=loaded.name,
            images=image_tensor(np.stack([view.picture for view in loaded.views]), self._encoding),
            world_T_camera=torch.from_numpy(np.stack([view.world_T_camera for view in loaded.views])).float(),
            K=torch.from_numpy(np.stack([view.K for view in loaded.views])).float(),
            targets={name: torch.from_numpy(values) for name, values in targets.items()},
            ground_truth=loaded.labels if self._with_ground_truth else None,
        )

    def load(self, item: tuple[int, int]) -> LoadedViews:
        """Return the views of an item (index, draw), augmented and at the size of the samples, and the labels."""
        index, draw = item
        scene, reference = self._references[index]
        rng = stream(self._seed, index, f"learn/samples/{draw}")
        selected = self._select_views(scene, reference, rng)
        views = [read_view(view, eye) for view, eye in selected]
        check_sizes(views, reference.folder)
        for view, (stored, eye) in zip(views, selected, strict=True):
            check_colours(view.picture, stored.folder / f"{eye}.png")
        window, of_source = self._windows(reference)
        views = [cut(views[0], window), *(cut(view, of_source) for view in views[1:])]
        labels = cut_labels(self._ground_truth(scene, reference), window)
        size = self._views.size
        if self._augment is not None:
            size = size or (views[0].picture.shape[0], views[0].picture.shape[1])
            views, labels = moved_pixels(views, labels, self._augment, rng)
        views = [scaled_view(view, size, self._views.fit) for view in views]
        check_sides(views[0].picture, reference.folder)
        if self._augment is not None:
            pictures = augmented(np.stack([view.picture for view in views]), self._augment, rng)
            views = [replace(view, picture=picture) for view, picture in zip(views, pictures, strict=True)]
        labels = scaled_ground_truth(labels, size, self._views.fit)
        if self._with_ground_truth:
            labels = replace(labels, surface=self._surface(scene))
        sensor = None
        if self._with_sensor_depth and self._converted is None and reference.depth_camera() is not None:
            depth = reference.sensor_depth()[window.slices]
            sensor = scaled_depth(depth, size, self._views.fit)
        return LoadedViews(str(reference.folder.relative_to(self.root)), tuple(views), labels, sensor)

    def labels(self, index: int) -> GroundTruth:
        """Return the labels of a reference at the size of the samples, without augmentation.

        The last ones are kept: those who ask do so for one object after another.
        """
        if self._last_labels is None or self._last_labels[0] != index:
            self._last_labels = index, self._unmoved_labels(index)
        return self._last_labels[1]

    def _unmoved_labels(self, index: int) -> GroundTruth:
        scene, reference = self._references[index]
        labels = cut_labels(self._ground_truth(scene, reference), self._windows(reference)[0])
        return scaled_ground_truth(labels, self._views.size, self._views.fit)

    def cameras(self, index: int) -> list[tuple[np.ndarray, np.ndarray, tuple[int, int]]]:
        """Return pose, K and (height, width) of all views of a reference's scene, the reference first.

        Cameras are those of the stored pictures. Where a converted data set does not say where its cameras stand, there
        is the reference alone.
        """
        scene, reference = self._references[index]
        cameras, number = self._cameras(scene), scene.views.index(reference)
        if self._converted is not None and self._converted.has.get("camera-poses", 0) < self._converted.views:
            cameras, number = [cameras[number]], 0
        ordered = [cameras[number], *cameras[:number], *cameras[number + 1 :]]
        return [(one.world_T_camera, np.array(one.K), (one.height, one.width)) for one in ordered]

    def depth_range(self, max_views: int = DEPTH_VIEWS) -> tuple[float, float]:
        """Return the depths between which objects lie, over evenly spaced references [m] (`range_of_depths`).

        Parameters
        ----------
        max_views : int
            Approximate limit of the views that are read.
        """
        return range_of_depths(self.object_depths(max_views))

    def object_depths(self, max_views: int) -> np.ndarray:
        """Return depths of object pixels of evenly spaced references, as many of each [m], (n,).

        They are those of the table where there are no objects.
        """
        step = max(len(self) // max_views, 1)
        of_objects, of_table = [], []
        for scene, view in self._references[::step]:
            labels = self._ground_truth(scene, view)
            if self._converted is not None and "depth" not in self._converted.has:
                of_objects.append(np.quantile(box_depths(labels), _QUANTILES))
            for found, surface in ((of_objects, labels.instances > TABLE_ID), (of_table, labels.instances == TABLE_ID)):
                depths = labels.Z[surface & np.isfinite(labels.Z)]
                if depths.size:
                    found.append(np.quantile(depths, _QUANTILES))
        if not of_objects + of_table:
            raise InputError(self.root, "a view with a surface in it", "none")
        return np.concatenate(of_objects or of_table)

    def fitted_camera(self, index: int) -> tuple[np.ndarray, tuple[int, int]]:
        """Return K and (height, width) of a reference at the size of the samples, without augmentation."""
        reference = self._references[index][1]
        window, _ = self._windows(reference)
        fit = fitted(window.size, self._views.size, self._views.fit)
        return fitted_K(windowed_K(np.array(read_camera(reference).K), window), fit), fit.new

    def focal_baseline(self) -> float:
        """Return the greatest focal length times baseline of the stereo pairs, at the size of the samples [px m]."""
        baselines = [read_camera(view).baseline or 0.0 for _, view in self._references]
        focal = (float(self.fitted_camera(index)[0][0, 0]) for index in range(len(self)))
        return max(length * baseline for length, baseline in zip(focal, baselines, strict=True))

    def _windows(self, reference: StoredView) -> tuple[Window, Window]:
        return stored_windows(read_camera(reference), self._views.convergence, reference.folder)

    def _can_be_reference(self, view: StoredView) -> bool:
        return self._views.rule != "grid" or _grid_index(view, read_camera(view)) <= LAST_REFERENCE

    def _ground_truth(self, scene: StoredScene, view: StoredView) -> GroundTruth:
        record = read_camera(view)
        if self._converted is not None:
            return read_partial_truth(view, self._converted, (record.height, record.width))
        return read_ground_truth(view, self._objects(scene), (record.height, record.width))

    def _select_views(
        self, scene: StoredScene, reference: StoredView, rng: np.random.Generator
    ) -> list[tuple[StoredView, Eye]]:
        if self._views.rule == "stereo":
            return [(reference, "left"), (reference, "right")]
        others = self._candidates(scene, reference)
        wanted = self._views.count - 1
        if len(others) < wanted:
            raise InputError(
                f"{reference.folder}: views",
                f"{wanted} others by the rule {self._views.rule}",
                f"{len(others)} of the {len(scene.views)} views of the scene",
            )
        drawn = rng.permutation(len(others))[:wanted]
        return [(reference, "left"), *((others[index], "left") for index in drawn)]

    def _candidates(self, scene: StoredScene, reference: StoredView) -> Sequence[StoredView]:
        views = scene.views
        cameras = self._cameras(scene)
        number = views.index(reference)
        if self._views.rule == "grid":
            near = grid_neighbours(_grid_index(reference, cameras[number]))
            return [view for view, camera in zip(views, cameras, strict=True) if camera.grid_index in near]
        positions = np.stack([camera.world_T_camera[:3, 3] for camera in cameras])
        pool = max(self._views.pool, self._views.count - 1)
        return [views[index] for index in nearest_cameras(positions, number, pool)]

    def _cameras(self, scene: StoredScene) -> list[CameraFile]:
        if scene.scene_id not in self._cameras_of:
            self._cameras_of[scene.scene_id] = [read_camera(view) for view in scene.views]
        return self._cameras_of[scene.scene_id]

    def _surface(self, scene: StoredScene) -> dict[int, np.ndarray]:
        if self._converted is not None:
            return {}  # no mesh is stored; keypoints stand for the surface
        if scene.scene_id not in self._surface_of:
            self._surface_of[scene.scene_id] = scene_surface_points(scene.scene())
        return self._surface_of[scene.scene_id]

    def _objects(self, scene: StoredScene) -> ObjectsFile:
        if scene.scene_id not in self._objects_of:
            self._objects_of[scene.scene_id] = scene.objects()
        return self._objects_of[scene.scene_id]


def range_of_depths(depths: np.ndarray) -> tuple[float, float]:
    """Return the depths between which objects lie [m]: quantiles (`DEPTH_QUANTILES`) of those of `object_depths`.

    Between the extremes of table and objects most planes would lie where no object is: with 24 inverse planes from 0.20
    to 1.83 m, 99 % of object pixels were between 9 of them.
    """
    near, far = np.quantile(depths, DEPTH_QUANTILES)
    return float(near), float(far)


def image_tensor(images: np.ndarray, encoding: Encoding) -> Tensor:
    """Return images, (V, H, W, 3) uint8, as input of a network: (V, 3, H, W) float32 in [0, 1].

    Contiguous, not channels-last: the backward pass of some convolutions of torch 2.13 on a CPU (1 x 1, stride 2, 16
    channels or fewer) writes out of bounds for channels-last memory.
    """
    values = torch.from_numpy(images).movedim(-1, 1).float() / 255.0
    if encoding.stretch_contrast:
        low, high = values.amin((1, 2, 3), keepdim=True), values.amax((1, 2, 3), keepdim=True)
        values = (values - low) / (high - low)
    return values.contiguous()


@dataclass(frozen=True, eq=False)
class Batch:
    """A batch of samples."""

    names: tuple[str, ...]
    images: Tensor  #: (B, V, 3, H, W)
    world_T_camera: Tensor  #: (B, V, 4, 4)
    K: Tensor  #: (B, V, 3, 3)
    targets: dict[str, Tensor]
    ground_truths: tuple[GroundTruth | None, ...]

    def to(self, device: torch.device) -> Batch:
        """Return the batch on another device."""
        moved = {name: value.to(device, non_blocking=True) for name, value in self.targets.items()}
        images, poses, K = (x.to(device, non_blocking=True) for x in (self.images, self.world_T_camera, self.K))
        return Batch(self.names, images, poses, K, moved, self.ground_truths)


def _grid_index(view: StoredView, camera: CameraFile) -> int:
    if camera.grid_index is None:
        where = f"{view.folder}: views.rule"
        raise InputError(where, "distance or stereo, as this camera stands off the 57-view grid", "grid")
    return camera.grid_index


def collate(samples: Sequence[Sample]) -> Batch:
    """Return samples as one batch; InputError where their images differ in size."""
    sizes = {sample.images.shape[-2:]: sample.name for sample in samples}
    if len(sizes) > 1:
        shown = " and ".join(f"{h} x {w} px in {name}" for (h, w), name in sizes.items())
        raise InputError("a batch", "pictures of one size", shown)
    return Batch(
        names=tuple(sample.name for sample in samples),
        images=torch.stack([sample.images for sample in samples]),
        world_T_camera=torch.stack([sample.world_T_camera for sample in samples]),
        K=torch.stack([sample.K for sample in samples]),
        targets={name: torch.stack([sample.targets[name] for sample in samples]) for name in samples[0].targets},
        ground_truths=tuple(sample.ground_truth for sample in samples),
    )
