"""The plane sweep: features of a source view, warped to the reference view through fronto-parallel planes.

(Collins, "A Space-Sweep Approach to True Multi-Image Matching", CVPR 1996; Yao et al., "MVSNet", ECCV 2018, eq. 1.)
"""

from __future__ import annotations

from typing import Literal

import torch
from torch import Tensor
from torch.nn import functional

#: Points at a smaller depth than this count as behind the camera [m].
MIN_DEPTH = 1e-3


def plane_depths(depth_range: Tensor, count: int, spacing: Literal["linear", "inverse"]) -> Tensor:
    """Return the depths of the planes, (B, D) [m], ascending.

    Parameters
    ----------
    depth_range : (B, 2) Tensor
        Depth of the first and the last plane [m].
    count : int
        Number of planes D.
    spacing : str
        ``linear``: equal steps of depth. ``inverse``: equal steps of 1 / depth (of disparity), which are equal steps
        along the epipolar line where the cameras stand side by side.
    """
    fraction = torch.linspace(0.0, 1.0, count, device=depth_range.device, dtype=depth_range.dtype)
    near, far = depth_range[:, :1], depth_range[:, 1:]
    if spacing == "linear":
        return near + (far - near) * fraction
    return 1.0 / (1.0 / near + (1.0 / far - 1.0 / near) * fraction)


def feature_intrinsics(K: Tensor, stride: int) -> Tensor:
    """Return the intrinsic matrices of features at 1/stride of the image size, (..., 3, 3).

    Convolutions of stride 2 put feature i over pixel ``stride * i``, and pixel (0, 0) has its centre at (0, 0): so
    image coordinates are divided by the stride, without a shift.
    """
    return K * K.new_tensor([1.0 / stride, 1.0 / stride, 1.0])[:, None]


def inverse_intrinsics(K: Tensor) -> Tensor:
    """Return the inverses of intrinsic matrices, (B, 3, 3), whose last row is 0, 0, 1.

    In closed form, which needs no solver: a GPU does not wait for the processor, and ONNX has no inverse of matrices.
    """
    (a, b), (c, d) = K[:, 0, :2].unbind(-1), K[:, 1, :2].unbind(-1)
    x, y = K[:, 0, 2], K[:, 1, 2]
    determinant = a * d - b * c
    zero, one = torch.zeros_like(a), torch.ones_like(a)
    rows = [d, -b, b * y - d * x, -c, a, c * x - a * y, zero, zero, determinant * one]
    return (torch.stack(rows, dim=-1) / determinant[:, None]).unflatten(-1, (3, 3))


def source_T_reference(world_T_camera: Tensor) -> Tensor:
    """Return the pose of the reference (view 0) in each source view, (B, V - 1, 4, 4), of rigid poses, (B, V, 4, 4)."""
    rotation, translation = world_T_camera[:, 1:, :3, :3].mT, world_T_camera[:, 1:, :3, 3:]
    source_T_world = world_T_camera.new_zeros(world_T_camera[:, 1:].shape)
    source_T_world[..., :3, :3] = rotation
    source_T_world[..., :3, 3:] = -rotation @ translation
    source_T_world[..., 3, 3] = 1.0
    return source_T_world @ world_T_camera[:, :1]


def source_cameras(world_T_camera: Tensor, K: Tensor, stride: int) -> list[tuple[Tensor, Tensor, Tensor]]:
    """Return the cameras of each source view as `plane_sweep_grid` takes them, for features at 1/stride of the size.

    Parameters
    ----------
    world_T_camera, K : (B, V, 4, 4) and (B, V, 3, 3) Tensor
        Poses [m], and intrinsic matrices at full size [px]; the first view is the reference.
    stride : int
        Of the features.
    """
    poses, small_K = source_T_reference(world_T_camera), feature_intrinsics(K, stride)
    return [(poses[:, view], small_K[:, 0], small_K[:, view + 1]) for view in range(K.shape[1] - 1)]


def plane_sweep_grid(
    source_T_reference: Tensor, K_reference: Tensor, K_source: Tensor, planes: Tensor, size: tuple[int, int]
) -> tuple[Tensor, Tensor]:
    """Return where each reference pixel, lifted to each plane, projects in a source view.

    Planes that bend, with a depth of their own at each pixel, are taken as well.

    Parameters
    ----------
    source_T_reference : (B, 4, 4) Tensor
        Pose of the reference in the source [m].
    K_reference, K_source : (B, 3, 3) Tensor
        Intrinsic matrices at the size of the features [px].
    planes : (B, D) or (B, D, h, w) Tensor
        Depths of the planes in the reference [m].
    size : (int, int)
        Height and width of the features [px].

    Returns
    -------
    pixels : (B, D, h, w, 2) Tensor
        Image coordinates (u, v) in the source [px]; finite where ``visible`` is false as well.
    visible : (B, D, h, w) Tensor of bool
        In front of the source camera and inside its image.
    """
    height, width = size
    y, x = torch.meshgrid(
        torch.arange(height, device=planes.device), torch.arange(width, device=planes.device), indexing="ij"
    )
    pixels = torch.stack([x, y, torch.ones_like(x)]).reshape(3, -1).to(planes)  # homogeneous, (3, h w)
    # K_s (R d K_r^-1 p + t): one matrix per sample for the rays, and one column for the translation.
    rays = K_source @ source_T_reference[:, :3, :3] @ inverse_intrinsics(K_reference) @ pixels  # (B, 3, h w)
    shift = K_source @ source_T_reference[:, :3, 3:]  # (B, 3, 1)
    depths = planes[..., None] if planes.ndim == 2 else planes.flatten(2)  # (B, D, 1) or (B, D, h w)
    projected = rays[:, :, None] * depths[:, None] + shift[..., None]  # (B, 3, D, h w)
    Z = projected[:, 2]
    in_front = Z > MIN_DEPTH
    uv = projected[:, :2] / torch.where(in_front, Z, 1.0)[:, None]  # (B, 2, D, h w)
    u, v = uv.unbind(1)
    visible = in_front & (u >= -0.5) & (u <= width - 0.5) & (v >= -0.5) & (v <= height - 0.5)
    shape = (*planes.shape[:2], height, width)
    return torch.where(in_front[:, None], uv, -1.0).movedim(1, -1).reshape(*shape, 2), visible.reshape(shape)


def warp(features: Tensor, pixels: Tensor) -> Tensor:
    """Return features, (B, C, h, w), sampled bilinearly at image coordinates, (B, D, h, w, 2), as (B, C, D, h, w)."""
    height, width = features.shape[-2:]
    # grid_sample with align_corners has -1 and 1 at the centres of the first and the last pixel.
    scale = pixels.new_tensor([2.0 / max(width - 1, 1), 2.0 / max(height - 1, 1)])
    grid = (pixels * scale - 1.0).flatten(1, 2)  # (B, D h, w, 2)
    values = functional.grid_sample(features, grid, mode="bilinear", padding_mode="border", align_corners=True)
    return values.reshape(*features.shape[:2], *pixels.shape[1:4])  # (B, C, D h, w) to (B, C, D, h, w)
