"""Samples of KeyPose: windows of both eyes around one object, and its keypoints in them."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import torch
from torch.utils.data import Dataset as TorchDataset

from ...annotate.projection import inverse_pose
from ...core.errors import InputError
from ...core.randomness import stream
from ..networks.baselines.settings import KeyPoseSettings
from ..targets.encoding import CORRECTED
from ..targets.keypoints import object_keypoints, parsed_order
from ..targets.objects import ViewObject
from .geometric_augment import mirrored_view
from .keypose_augment import window_augmented
from .object_cases import Findings, Location, ObjectCase, check_has_cases, missed_cases, object_cases, object_of
from .samples import LoadedViews, Sample, SampleDataset, image_tensor
from .scaling import BORDER
from .views import CameraView

#: How far the right window is moved to the left of the left one, and the object to the right of the left window's
#: middle, over the width of a window: 30 of 180 px.
SHIFT = 1.0 / 6.0
#: Greatest turn of the cameras about their x axis in training [rad].
_TURN = np.radians(5.0)
#: Windows nearer to the border of the picture are left out by the released code, over the width of a window: 10 px.
_BORDER = 10.0 / 180.0
#: Other views in which keypoints are compared.
OTHER_VIEWS = 5


@dataclass(frozen=True, eq=False)
class _Pair:
    """Both eyes, and the keypoints of an object in the left camera's frame."""

    views: tuple[CameraView, CameraView]
    points: np.ndarray  #: (K, 3) [m]
    orders: np.ndarray  #: (n, K)
    mirrored: bool


class KeyPoseSamples(TorchDataset):
    """Windows around objects; an item is (index, draw) as in `SampleDataset`.

    Parameters
    ----------
    base : SampleDataset
        Stereo pairs.
    settings : KeyPoseSettings
        Window, keypoints and augmentation.
    released : bool
        Whether windows near the border are left out, as the released code does in tests as well; `dropped` counts
        them. Otherwise they are filled with grey.
    training : bool
        Whether windows are moved and augmented at random.
    seed : int
        Seed of the draws.
    location : str
        ``truth``: windows around the mean of the true keypoints; ``jitter``: moved at random; ``detector``: around
        `findings`, without objects that were missed.
    findings : mapping, optional
        Of a detector.
    """

    def __init__(
        self,
        base: SampleDataset,
        settings: KeyPoseSettings,
        *,
        released: bool = False,
        training: bool = False,
        seed: int = 0,
        location: Location = "truth",
        findings: Findings | None = None,
    ) -> None:
        self.base, self._settings, self._training, self._seed = base, settings, training, seed
        self._moved = training or location == "jitter"
        self._findings = findings if location == "detector" else None
        every = object_cases(base)
        self.missed = missed_cases(every, self._findings)
        every = [case for case in every if case not in self.missed]
        self.dropped = [case for case in every if released and self._at_border(case)]
        self.cases = [case for case in every if case not in self.dropped]
        if not (self.missed or self.dropped):
            check_has_cases(self.cases, str(base.root))

    def __len__(self) -> int:
        """Return the number of objects."""
        return len(self.cases)

    def __getitem__(self, item: tuple[int, int]) -> Sample:
        """Return the sample of an item (index, draw)."""
        index, draw = item
        case, rng = self.cases[index], stream(self._seed, index, f"learn/keypose/{draw}")
        loaded = self.base.load((case.view, draw))
        target = object_of(loaded.labels, case, loaded.name)
        pair = self._pair(loaded, target, rng)
        turn = self._training and self._settings.augment == "native"
        R = _rotation_about_x(rng.uniform(-_TURN, _TURN) if turn else 0.0)
        points = pair.points @ R.T
        corners = self._corners(case, points, pair, rng)
        windows = [
            self._window(view, R, corner, self._settings.crop) for view, corner in zip(pair.views, corners, strict=True)
        ]
        pictures = np.stack([view.picture for view in windows])
        if turn:
            # The object's area is at most that of the window, which the released code takes in its place.
            area = min(target.visible, self._settings.crop[0] * self._settings.crop[1])
            pictures = window_augmented(pictures, area, rng)
        targets = self._targets(case, windows, points[pair.orders], rng, pair.mirrored)
        return Sample(
            name=f"{loaded.name}: object {case.object_id}",
            images=image_tensor(pictures, CORRECTED),
            world_T_camera=torch.from_numpy(np.stack([view.world_T_camera for view in windows])).float(),
            K=torch.from_numpy(np.stack([view.K for view in windows])).float(),
            targets={name: torch.from_numpy(np.asarray(value)) for name, value in targets.items()},
            ground_truth=loaded.labels,
        )

    def keypoint_count(self) -> int:
        """Return how many keypoints the objects have; InputError where their numbers differ."""
        counts = {}
        for case in self.cases:
            labels = self.base.labels(case.view)
            target = object_of(labels, case, str(self.base.root))
            counts[len(self._keypoints(target, labels.keypoints[target.id])[0])] = case
            if self._settings.points == "axis":
                break
        if len(counts) > 1:
            raise InputError(f"{self.base.root}: keypoints", "objects with as many keypoints each", sorted(counts))
        return next(iter(counts))

    def _keypoints(self, target: ViewObject, stored: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return object_keypoints(target, stored, self._settings.points, self._settings.orderings)

    def _pair(self, loaded: LoadedViews, target: ViewObject, rng: np.random.Generator) -> _Pair:
        left, right = loaded.views
        local, orders = self._keypoints(target, loaded.labels.keypoints[target.id])
        points = local @ target.camera_T_object[:3, :3].T + target.camera_T_object[:3, 3]
        if not (self._training and rng.uniform() < self._settings.flip):
            return _Pair((left, right), points, orders, mirrored=False)
        # The right eye's mirror image is the left one of the mirrored pair.
        baseline = np.linalg.norm(right.world_T_camera[:3, 3] - left.world_T_camera[:3, 3])
        order = self._settings.mirror_order
        swapped = points if order is None else points[parsed_order(order)]
        return _Pair(
            (mirrored_view(right), mirrored_view(left)),
            (swapped - [baseline, 0.0, 0.0]) * [-1.0, 1.0, 1.0],
            orders,
            mirrored=True,
        )

    def _corners(
        self, case: ObjectCase, points: np.ndarray, pair: _Pair, rng: np.random.Generator
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the upper left pixels (x, y) of the windows of both eyes."""
        if self._findings is None:
            centre = _projected(points, pair.views[0].K).mean(0)
        else:
            centre = np.array(self._findings[_key(case)].peak)
        if self._moved:
            width = self._settings.crop[1]
            centre = centre + rng.uniform(-1.0, 1.0, 2) * self._settings.dither * width
        return _corners_at(centre, self._settings.crop)

    def _window(self, view: CameraView, R: np.ndarray, corner: np.ndarray, size: tuple[int, int]) -> CameraView:
        """Return a window of a view whose camera is turned."""
        K = view.K.copy()
        K[:2, 2] -= corner
        homography = K @ R @ np.linalg.inv(view.K)
        picture = cv2.warpPerspective(
            view.picture, homography, (size[1], size[0]), flags=cv2.INTER_LINEAR, borderValue=(BORDER,) * 3
        )
        pose = view.world_T_camera.copy()
        pose[:3, :3] = pose[:3, :3] @ R.T
        return CameraView(picture, pose, K)

    def _targets(
        self,
        case: ObjectCase,
        windows: list[CameraView],
        points: np.ndarray,
        rng: np.random.Generator,
        mirrored: bool,
    ) -> dict[str, np.ndarray | np.generic]:
        left, right = (np.stack([_projected(one, view.K) for one in points]) for view in windows)
        left_T_right = inverse_pose(windows[0].world_T_camera) @ windows[1].world_T_camera
        baseline = left_T_right[0, 3]
        # The right camera has the same axes and K but for its window, so only the column differs.
        right[..., 0] -= windows[1].K[0, 0] * baseline / points[..., 2]
        keypoints = np.concatenate([left, left[..., :1] - right[..., :1]], axis=-1)
        matrices, known = self._other_views(case, windows[0].world_T_camera, rng)
        return {
            "keypoints": _padded(keypoints).astype(np.float32),
            "points": _padded(points).astype(np.float32),
            "projections": matrices.astype(np.float32),
            "projection_mask": known & (not mirrored),
            "baseline": np.float32(baseline),
            "object_id": np.int64(case.object_id),
        }

    def _other_views(
        self, case: ObjectCase, world_T_camera: np.ndarray, rng: np.random.Generator
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return projections of the camera's frame into other views, (5, 3, 4) in half pictures, and which exist."""
        others = self.base.cameras(case.view)[1:]
        drawn = rng.permutation(len(others))[:OTHER_VIEWS]
        matrices, known = np.zeros((OTHER_VIEWS, 3, 4)), np.zeros(OTHER_VIEWS, bool)
        matrices[:, 2, 3] = 1.0
        for row, number in enumerate(drawn):
            pose, K, (height, width) = others[number]
            scale = np.diag([2.0 / width, 2.0 / height, 1.0])
            matrices[row], known[row] = scale @ K @ (inverse_pose(pose) @ world_T_camera)[:3], True
        return matrices, known

    def _at_border(self, case: ObjectCase) -> bool:
        labels = self.base.labels(case.view)
        target = object_of(labels, case, str(self.base.root))
        local, _ = self._keypoints(target, labels.keypoints[target.id])
        K, size = self.base.fitted_camera(case.view)
        points = local @ target.camera_T_object[:3, :3].T + target.camera_T_object[:3, 3]
        (left, top), _ = _corners_at(_projected(points, K).mean(0), self._settings.crop)
        height, width = self._settings.crop
        border = _BORDER * width
        # The right window reaches farther to the left.
        return bool(
            left - round(SHIFT * width) < border
            or top < border
            or left + width > size[1] - border
            or top + height > size[0] - border
        )


def _corners_at(centre: np.ndarray, crop: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    height, width = crop
    shift = round(SHIFT * width)
    left = np.rint(centre - (width / 2.0 + shift, height / 2.0))
    return left, left - (shift, 0.0)


def _padded(values: np.ndarray) -> np.ndarray:
    """Return keypoints in two orders or more, (n, K, 3), the first again where there is one: batches have one shape."""
    return np.concatenate([values, values[:1]]) if len(values) < 2 else values


def _projected(points: np.ndarray, K: np.ndarray) -> np.ndarray:
    """Return image coordinates (x, y) of points in a camera's frame, (n, 2) [px]."""
    homogeneous = points @ K.T
    return homogeneous[:, :2] / homogeneous[:, 2:]


def _rotation_about_x(angle: float) -> np.ndarray:
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, cosine, -sine], [0.0, sine, cosine]])


def _key(case: ObjectCase) -> tuple[int, int]:
    return case.view, case.object_id
