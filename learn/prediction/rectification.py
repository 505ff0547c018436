"""From pictures as lenses take them to those that networks see, and back: undistorted, and pairs rectified.

(Fusiello, Trucco & Verri, "A Compact Algorithm for Rectification of Stereo Pairs", 2000: both cameras are turned so
that x lies along the baseline, and the optical axis is the mean of theirs, as far as it can be.)
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from ...annotate.projection import pixel_rays
from ...dataset.cameras.lens import distorted, undistorted
from ..data.scaling import BORDER
from ..data.views import CameraView
from .own_pictures import OwnPicture

#: Largest angle between the optical axes of a stereo pair, and between its baseline and the rows of its left picture
#: [rad]: 20 and 30 degrees. Other pairs are two views of a scene, which are matched as they are.
_MOST_TURN, _MOST_TILT = math.radians(20.0), math.radians(30.0)
#: Turn, and distance beside the x axis over the baseline, from which a pair is rectified again: a tenth of a pixel at a
#: focal length of 1000 px.
_RECTIFIED = 1e-4


@dataclass(frozen=True, eq=False)
class Pinhole:
    """The picture of a pinhole camera at the place of a user's camera, perhaps turned."""

    view: CameraView
    source: OwnPicture
    turn: np.ndarray  #: (3, 3): takes coordinates of the view's camera to those of the source's

    @property
    def same(self) -> bool:
        """Whether the picture is the user's own, pixel by pixel."""
        return self.view.picture is self.source.picture


def pinholes(pictures: Sequence[OwnPicture]) -> list[Pinhole]:
    """Return what networks see of pictures of one scene: without distortion, and as a rectified pair where it is one.

    Parameters
    ----------
    pictures : sequence of OwnPicture
        Two or more; the first is the reference.
    """
    turns = [np.eye(3)] * len(pictures)
    if len(pictures) == 2:
        turns = _rectifying_turns(pictures[0].world_T_camera, pictures[1].world_T_camera)
    if all(np.array_equal(turn, np.eye(3)) for turn in turns):
        return [_pinhole(one, np.eye(3), one.K) for one in pictures]
    left, right = pictures
    K = _common_K(left, right, turns)
    return [_pinhole(one, turn, K) for one, turn in zip(pictures, turns, strict=True)]


def _rectifying_turns(left: np.ndarray, right: np.ndarray) -> list[np.ndarray]:
    """Return the turns ``camera_R_rectified`` of both: none where they are rectified, or are no stereo pair."""
    left_T_right = np.linalg.inv(left) @ right
    R, t = left_T_right[:3, :3], left_T_right[:3, 3]
    baseline = float(np.linalg.norm(t))
    none = [np.eye(3), np.eye(3)]
    if not baseline:
        return none
    x = t / baseline * (1.0 if t[0] >= 0.0 else -1.0)
    if R[2, 2] < math.cos(_MOST_TURN) or x[0] < math.cos(_MOST_TILT):
        return none
    if np.abs(R - np.eye(3)).max() < _RECTIFIED and np.abs(t[1:]).max() < _RECTIFIED * baseline:
        return none
    ahead = R[:, 2] + np.array([0.0, 0.0, 1.0])
    ahead = ahead - (ahead @ x) * x
    z = ahead / np.linalg.norm(ahead)
    turn = np.stack([x, np.cross(z, x), z], axis=1)
    return [turn, R.T @ turn]


def _common_K(left: OwnPicture, right: OwnPicture, turns: Sequence[np.ndarray]) -> np.ndarray:
    """Return an intrinsic matrix for both rectified pictures, of the left one's size, with the middle in the middle."""
    focal = math.sqrt(left.K[0, 0] * left.K[1, 1])
    middles = []
    for one, turn in zip((left, right), turns, strict=True):
        height, width = one.size
        ray = turn.T @ np.linalg.inv(one.K) @ np.array([(width - 1) / 2, (height - 1) / 2, 1.0])
        middles.append(ray[:2] / ray[2])
    height, width = left.size
    cx, cy = np.array([(width - 1) / 2, (height - 1) / 2]) - focal * np.mean(middles, axis=0)
    return np.array([[focal, 0.0, cx], [0.0, focal, cy], [0.0, 0.0, 1.0]])


def _pinhole(source: OwnPicture, turn: np.ndarray, K: np.ndarray) -> Pinhole:
    pose = source.world_T_camera.copy()
    pose[:3, :3] = pose[:3, :3] @ turn
    if source.distortion.absent and np.array_equal(turn, np.eye(3)):
        return Pinhole(CameraView(source.picture, pose, K), source, turn)
    rays = pixel_rays(*source.size, K) @ turn.T
    # Rays that do not come from the front have no pixel, and points far outside are no picture either.
    slopes = rays[..., :2] / np.maximum(rays[..., 2:], 1e-6)
    bent = slopes if source.distortion.absent else distorted(slopes, source.distortion)
    at = (bent @ source.K[:2, :2].T + source.K[:2, 2]).astype(np.float32)
    picture = cv2.remap(
        source.picture.astype(np.float32),
        np.ascontiguousarray(at[..., 0]),
        np.ascontiguousarray(at[..., 1]),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=(BORDER, BORDER, BORDER),
    )
    return Pinhole(CameraView(np.rint(picture).clip(0, 255).astype(np.uint8), pose, K), source, turn)


def seen_at(pinhole: Pinhole) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return where each pixel of the user's picture lies in the pinhole's.

    Returns
    -------
    rows, columns : (H, W) int
        The nearest pixel there.
    scale : (H, W) float
        Depth along the user's optical axis over depth along the pinhole's; NaN where the pixel lies outside.
    """
    height, width = pinhole.source.size
    v, u = np.mgrid[:height, :width].astype(np.float64)
    slopes = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(pinhole.source.K).T
    slopes = slopes[..., :2]
    if not pinhole.source.distortion.absent:
        slopes = undistorted(slopes, pinhole.source.distortion)
    rays = np.concatenate([slopes, np.ones_like(slopes[..., :1])], axis=-1) @ pinhole.turn  # of the pinhole's frame
    at = rays / rays[..., 2:] @ pinhole.view.K.T
    with np.errstate(invalid="ignore"):
        columns, rows = np.rint(at[..., 0]), np.rint(at[..., 1])
        inside = (rays[..., 2] > 0.0) & (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    scale = np.where(inside, 1.0 / rays[..., 2], np.nan)
    return np.where(inside, rows, 0).astype(int), np.where(inside, columns, 0).astype(int), scale


def at_source(pose: np.ndarray, pinhole: Pinhole) -> np.ndarray:
    """Return poses in the frame of the user's camera, (n, 4, 4), of poses in the pinhole's."""
    turned = pose.copy()
    turned[:, :3] = pinhole.turn @ pose[:, :3]
    return turned
