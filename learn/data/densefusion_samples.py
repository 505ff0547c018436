"""Samples of DenseFusion: a window around an object, points of its depth, and a model of its surface."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy

import cv2
import numpy as np
import torch
from torch.utils.data import Dataset as TorchDataset

from ...core.randomness import stream
from ..networks.baselines.settings import DenseFusionSettings
from ..targets.encoding import CORRECTED
from ..targets.objects import ViewObject
from .object_cases import Findings, Location, ObjectCase, check_has_cases, missed_cases, object_cases, object_of
from .samples import LoadedViews, Sample, SampleDataset, image_tensor
from .semi_global import semi_global_depth

#: Depth of the reference of loaded views, (H, W) [m]; 0 where it is unknown.
DepthSource = Callable[[LoadedViews], np.ndarray]
#: Sides of the released windows are multiples of this [px].
_RELEASED_STEP = 40
#: Side of a window over that of the box around a mask.
_MARGIN = 1.1
#: Ranges of the colour augmentation: brightness, contrast and saturation, and hue [turns] (released code).
_JITTER, _HUE = 0.2, 0.05


class DenseFusionSamples(TorchDataset):
    """Objects with their mask and depth; an item is (index, draw) as in `SampleDataset`.

    Parameters
    ----------
    base : SampleDataset
        Stereo pairs, with ground truth.
    settings : DenseFusionSettings
        With `categories`.
    depth_of : callable
        The depth that it is given.
    released : bool
        Whether windows have the released sizes, multiples of 40 px, in place of one size.
    training : bool
        Whether colours and places are changed at random.
    seed : int
        Seed of the draws.
    location : str
        ``truth``: true masks; ``jitter``: true masks moved as KeyPose's windows are; ``detector``: those of
        `findings`, without objects that were missed. Objects of other categories than the settings' are `unknown`.
    findings : mapping, optional
        Of a detector.
    """

    def __init__(
        self,
        base: SampleDataset,
        settings: DenseFusionSettings,
        depth_of: DepthSource,
        *,
        released: bool = False,
        training: bool = False,
        seed: int = 0,
        location: Location = "truth",
        findings: Findings | None = None,
    ) -> None:
        self.base, self._settings, self._depth_of, self._released = base, settings, depth_of, released
        self._training, self._seed, self._location = training, seed, location
        self._findings = findings if location == "detector" else None
        every = object_cases(base)
        self.missed = missed_cases(every, self._findings)
        self.dropped: list[ObjectCase] = []
        every = [case for case in every if case not in self.missed]
        # A network has an output for each category that it has learnt, and none for others.
        known = settings.categories
        self.unknown = [case for case in every if known and self._category(case) not in known]
        self.cases = [case for case in every if case not in self.unknown]
        if not (self.missed or self.unknown):
            check_has_cases(self.cases, str(base.root))

    def __len__(self) -> int:
        """Return the number of objects."""
        return len(self.cases)

    def with_categories(self, categories: tuple[str, ...]) -> DenseFusionSamples:
        """Return the same samples with other categories in their settings."""
        other = copy(self)
        other._settings = self._settings.model_copy(update={"categories": categories})
        return other

    def categories(self) -> tuple[str, ...]:
        """Return the categories of the objects, sorted."""
        return tuple(sorted({self._category(case) for case in self.cases}))

    def _category(self, case: ObjectCase) -> str:
        return object_of(self.base.labels(case.view), case, str(self.base.root)).category

    def __getitem__(self, item: tuple[int, int]) -> Sample:
        """Return the sample of an item (index, draw)."""
        index, draw = item
        case, rng = self.cases[index], stream(self._seed, index, f"learn/densefusion/{draw}")
        loaded = self.base.load((case.view, draw))
        target = object_of(loaded.labels, case, loaded.name)
        mask = self._mask(case, loaded, rng)
        depth = self._depth_of(loaded)
        usable = mask & (depth > 0.0) & np.isfinite(depth)
        view = loaded.views[0]
        inverse, size = self._window(mask)
        picture = self._picture(view.picture, inverse, rng)
        points, pixels = _points(usable, depth, view.K, inverse, (size, picture.shape[1], self._settings.points), rng)
        lost = not points.any()
        model, pose = self._model(loaded, target, rng), target.camera_T_object.copy()
        if self._training:
            shift = rng.uniform(-self._settings.shift, self._settings.shift, 3)
            points, pose[:3, 3] = points + shift, pose[:3, 3] + shift
        symmetry = target.symmetry
        targets = {
            "cloud": points.astype(np.float32),
            "pixels": pixels,
            "category": np.int64(self._settings.categories.index(target.category)),
            "sizes": np.array([size, size]),
            "model": model.astype(np.float32),
            "pose": pose.astype(np.float32),
            "symmetric": np.bool_(symmetry.turns or symmetry.ball or len(symmetry.motions) > 1),
            "lost": np.bool_(lost),
            "object_id": np.int64(case.object_id),
        }
        return Sample(
            name=f"{loaded.name}: object {case.object_id}",
            images=image_tensor(picture[None], CORRECTED),
            world_T_camera=torch.from_numpy(view.world_T_camera.copy()[None]).float(),
            K=torch.from_numpy(view.K[None]).float(),
            targets={name: torch.from_numpy(np.asarray(value)) for name, value in targets.items()},
            ground_truth=loaded.labels,
        )

    def _mask(self, case: ObjectCase, loaded: LoadedViews, rng: np.random.Generator) -> np.ndarray:
        if self._findings is not None:
            return self._findings[(case.view, case.object_id)].mask
        mask = loaded.labels.instances == case.object_id
        if self._location != "jitter":
            return mask
        # As far as KeyPose's windows are moved: 20 of 756 px of a picture's width.
        across, down = np.rint(rng.uniform(-1.0, 1.0, 2) * mask.shape[1] * 20.0 / 756.0).astype(int)
        moved = np.zeros_like(mask)
        y, x = np.nonzero(mask)
        y, x = y + down, x + across
        inside = (y >= 0) & (y < mask.shape[0]) & (x >= 0) & (x < mask.shape[1])
        moved[y[inside], x[inside]] = True
        return moved if moved.any() else mask

    def _window(self, mask: np.ndarray) -> tuple[np.ndarray, int]:
        """Return the matrix from a window's pixels to the picture's, (2, 3), and the window's side [px]."""
        y, x = np.nonzero(mask)
        low, high = np.array([x.min(), y.min()]), np.array([x.max(), y.max()])
        side = float((high - low).max() + 1)
        if not self._released:
            scale, size = max(_MARGIN * side, 8.0) / self._settings.crop, self._settings.crop
            corner = (low + high) / 2.0 - scale * (size - 1) / 2.0
            return np.array([[scale, 0.0, corner[0]], [0.0, scale, corner[1]]]), size
        most = min(mask.shape) // _RELEASED_STEP * _RELEASED_STEP or min(mask.shape) // 8 * 8
        size = min(max(int(np.ceil(side / _RELEASED_STEP)), 1) * _RELEASED_STEP, most)
        limit = np.array([mask.shape[1] - size, mask.shape[0] - size])
        corner = np.clip(np.rint((low + high) / 2.0 - size / 2.0), 0, limit)
        return np.array([[1.0, 0.0, corner[0]], [0.0, 1.0, corner[1]]]), size

    def _picture(self, picture: np.ndarray, inverse: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Return the window; the released ones lie in the corner of a picture as large as the largest."""
        side = max(picture.shape[:2]) // 8 * 8 if self._released else self._settings.crop
        how = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        window = cv2.warpAffine(picture, inverse, (side, side), flags=how, borderMode=cv2.BORDER_REPLICATE)
        return jittered(window, rng) if self._training else window

    def _model(self, loaded: LoadedViews, target: ViewObject, rng: np.random.Generator) -> np.ndarray:
        # Converted data sets have no meshes; their keypoints stand for the surface.
        surface = loaded.labels.surface.get(target.id, loaded.labels.keypoints[target.id])
        surface = np.resize(surface, (max(len(surface), self._settings.model_points), 3))
        return surface[rng.permutation(len(surface))[: self._settings.model_points]]


def true_depth(loaded: LoadedViews) -> np.ndarray:
    """Return the true depth of the first surface, 0 where there is none."""
    return np.where(np.isfinite(loaded.labels.Z), loaded.labels.Z, 0.0)


def raw_depth(loaded: LoadedViews) -> np.ndarray:
    """Return the depth of the data set's depth camera, or what a stereo camera would find (`semi_global_depth`)."""
    if loaded.sensor_depth is not None:
        return loaded.sensor_depth
    return semi_global_depth(loaded.views[0], loaded.views[1])


def jittered(picture: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return a picture, (h, w, 3) uint8, with another brightness, contrast, saturation and hue."""
    image = picture.astype(np.float32) / 255.0
    brightness, contrast, saturation = rng.uniform(1.0 - _JITTER, 1.0 + _JITTER, 3)
    image = np.clip(image * brightness, 0.0, 1.0)
    mean = image.mean()
    hsv = cv2.cvtColor(np.clip((image - mean) * contrast + mean, 0.0, 1.0).astype(np.float32), cv2.COLOR_RGB2HSV)
    hsv[..., 0] = (hsv[..., 0] + 360.0 * rng.uniform(-_HUE, _HUE)) % 360.0
    hsv[..., 1] = np.clip(hsv[..., 1] * saturation, 0.0, 1.0)
    return np.rint(np.clip(cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB), 0.0, 1.0) * 255.0).astype(np.uint8)


def _points(
    usable: np.ndarray,
    depth: np.ndarray,
    K: np.ndarray,
    inverse: np.ndarray,
    counts: tuple[int, int, int],
    rng: np.random.Generator,
) -> tuple[np.ndarray, np.ndarray]:
    """Return points of drawn pixels, (n, 3) [m], and their pixels in the window, (n,) int64; zeros where none can be.

    Where there are fewer pixels than wanted they are repeated.
    """
    size, width, count = counts  # of the window, of the picture that it lies in, and of points
    inside = usable.copy()
    x_of, y_of = ((np.arange(n) - inverse[axis, 2]) / inverse[axis, axis] for axis, n in enumerate(usable.shape[::-1]))
    columns, rows = np.rint(x_of).astype(np.int64), np.rint(y_of).astype(np.int64)
    inside &= ((rows >= 0) & (rows < size))[:, None] & ((columns >= 0) & (columns < size))[None]
    y, x = np.nonzero(inside)
    if not len(y):
        return np.zeros((count, 3)), np.zeros(count, np.int64)
    chosen = np.resize(rng.permutation(len(y)), count)
    y, x = y[chosen], x[chosen]
    Z = depth[y, x].astype(np.float64)
    points = np.stack([(x - K[0, 2]) / K[0, 0] * Z, (y - K[1, 2]) / K[1, 1] * Z, Z], axis=1)
    return points, rows[y] * width + columns[x]
