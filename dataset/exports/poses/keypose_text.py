"""KeyPose's messages in the text form of protobuf (google-research, keypose/data.proto).

Transforms are camera_T_world, OpenCV axes, row by row; keypoints are pixels and planar depth.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ....annotate.projection import inverse_pose, project_camera, transformed
from ....procedural.description.camera import Camera
from ....render.frame import Eye

#: Pixel of a keypoint that is not in front of the camera ("if a keypoint is to be skipped", gen_tfrecords.py).
_SKIPPED = -1.0


@dataclass(frozen=True, eq=False)
class Target:
    """Keypoints as one camera sees them."""

    camera: Camera
    world_T_camera: np.ndarray  #: (4, 4), of the eye
    keypoints: np.ndarray  #: (n, 3) float, world frame [m]


def target(camera: Camera, eye: Eye, keypoints: np.ndarray) -> Target:
    """Return the keypoints, world frame [m], as one eye of a pair sees them."""
    pose = camera.world_T_camera if eye == "left" else camera.world_T_right
    return Target(camera, np.array(pose), keypoints)


def key_targets(own: Target, others: Sequence[Target]) -> str:
    """Return a message `KeyTargets`: the keypoints of a picture, and the same in several views."""
    lines = ["kp_target {", *_indented(_target(own)), "}"]
    for other in others:
        lines += ["proj_targets {", *_indented(_target(other)), "}"]
    return "\n".join(lines) + "\n"


def data_params(camera: Camera, keypoints: int) -> str:
    """Return a message `DataParams`: size, number of keypoints, camera."""
    lines = [f"resx: {camera.width}", f"resy: {camera.height}", f"num_kp: {keypoints}"]
    return "\n".join([*lines, "camera {", *_indented(_camera(camera)), "}"]) + "\n"


def _target(seen: Target) -> Iterator[str]:
    camera_T_world = inverse_pose(seen.world_T_camera)
    yield "transform {"
    yield from _indented(f"element: {value!r}" for value in camera_T_world.ravel().tolist())
    yield "}"
    yield "camera {"
    yield from _indented(_camera(seen.camera))
    yield "}"
    points = transformed(camera_T_world, seen.keypoints)
    pixels, _ = project_camera(points, seen.camera.K)
    for (u, v), (_, _, Z) in zip(pixels.tolist(), points.tolist(), strict=True):
        yield "keypoints {"
        yield from _indented(_keypoint(seen.camera, u, v, Z))
        yield "}"


def _keypoint(camera: Camera, u: float, v: float, Z: float) -> Iterator[str]:
    before = Z > 0.0 and not np.isnan(u)
    u, v = (u, v) if before else (_SKIPPED, _SKIPPED)
    inside = before and -0.5 <= u < camera.width - 0.5 and -0.5 <= v < camera.height - 0.5
    values = {"u": u, "v": v, "x": u / camera.width, "y": v / camera.height, "z": Z, "visible": float(inside)}
    yield from (f"{name}: {value!r}" for name, value in values.items())


def _camera(camera: Camera) -> Iterator[str]:
    cx, cy = camera.centre
    values = {"fx": camera.fx, "fy": camera.fy, "cx": cx, "cy": cy, "baseline": camera.baseline}
    values |= {"resx": float(camera.width), "resy": float(camera.height)}
    yield from (f"{name}: {float(value)!r}" for name, value in values.items())


def _indented(lines: Iterator[str]) -> Iterator[str]:
    return (f"  {line}" for line in lines)
