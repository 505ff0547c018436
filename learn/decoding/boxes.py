"""Boxes from the picture of their eight corners and the depth of their middle."""

from __future__ import annotations

from typing import Literal

import torch
from torch import Tensor

from ...annotate.boxes import CORNER_SIGNS
from .rotation import nearest_rotation, rotation_from_covariance

#: Smallest side that a box is given [m].
SMALLEST = 1e-3


def boxes_from_fields(
    vertices: Tensor,
    depth: Tensor,
    covariance: Tensor,
    K: Tensor,
    rotation: Literal["covariance", "vertices"] = "covariance",
) -> tuple[Tensor, Tensor]:
    """Return the pose and the size of boxes.

    The corners alone give the box up to its scale; of this, the rotation is kept as a guess that orders and signs the
    axes of the covariance. Then centre and size follow from the corners, that rotation and the depth.

    Parameters
    ----------
    vertices : (n, 8, 2) Tensor
        Image coordinates of the corners [px], numbered as `annotate.boxes.CORNER_SIGNS`.
    depth : (n,) Tensor
        Planar depth of the boxes' middles [m].
    covariance : (n, 3, 3) Tensor
        Covariance of their insides, camera axes [m^2].
    K : (n, 3, 3) Tensor
        Intrinsic matrices [px].
    rotation : str
        Where it comes from: the ``covariance``, or the ``vertices`` alone.

    Returns
    -------
    camera_T_object : (n, 4, 4) float64 Tensor
        Poses [m].
    size : (n, 3) float64 Tensor
        Sizes [m].
    """
    rays = _rays(vertices.double(), K.double())
    R = rotation_from_vertices(rays)
    if rotation == "covariance":
        R = rotation_from_covariance(covariance.double(), R)
    centre, size = _placed(rays, R, depth.double())
    pose = torch.eye(4, dtype=torch.float64, device=R.device).repeat(len(R), 1, 1)
    pose[:, :3, :3], pose[:, :3, 3] = R, centre
    return pose, size


def rotation_from_vertices(rays: Tensor) -> Tensor:
    """Return the rotation of boxes, (n, 3, 3), from the rays through their corners, (n, 8, 2), as x / z and y / z.

    A corner is c + A sigma with the middle c, the half axes A and the corner's signs sigma. Each ray gives two linear
    equations x - (x/z) z = 0, so the twelve numbers of c and A are the null vector of a 16 x 12 matrix, up to a factor
    whose sign puts the box before the camera. (The EPnP of Lepetit, Moreno-Noguer & Fua, IJCV 2009, section 3, with the
    middle and the axes as control points.) The rotation nearest to the directions of A is the box's.
    """
    signs = _signs(rays)
    one = torch.cat([torch.ones_like(signs[:, :1]), signs], dim=1)  # (8, 4): coefficients of c and of A's columns
    zero = torch.zeros(len(rays), 8, 4, dtype=rays.dtype, device=rays.device)
    part = one.expand_as(zero)
    across = torch.cat([part, zero, -rays[..., :1] * part], dim=2)
    down = torch.cat([zero, part, -rays[..., 1:] * part], dim=2)
    null = torch.linalg.svd(torch.cat([across, down], dim=1)).Vh[:, -1].reshape(-1, 3, 4)
    null = null * torch.where(null[:, 2, :1, None] < 0.0, -1.0, 1.0)
    axes = null[:, :, 1:]
    lengths = axes.norm(dim=1, keepdim=True)
    return nearest_rotation(axes / lengths.clamp_min(torch.finfo(axes.dtype).tiny))


def _placed(rays: Tensor, R: Tensor, depth: Tensor) -> tuple[Tensor, Tensor]:
    """Return middle, (n, 3), and size, (n, 3), by least squares over both coordinates of all corners."""
    signs = _signs(rays)
    rows = []
    for axis in (0, 1):
        place = torch.zeros(len(R), 8, 2, dtype=R.dtype, device=R.device)
        place[:, :, axis] = 1.0
        # c_axis + sum_j sigma_j s_j / 2 (R_axis,j - ray R_z,j) = ray z
        sides = 0.5 * signs * (R[:, None, axis] - rays[:, :, axis, None] * R[:, None, 2])
        rows.append(torch.cat([place, sides], dim=2))
    left = torch.cat(rows, dim=1)
    right = torch.cat([rays[..., 0], rays[..., 1]], dim=1) * depth[:, None]
    solved = torch.linalg.lstsq(left, right[..., None]).solution[..., 0]
    return torch.cat([solved[:, :2], depth[:, None]], dim=1), solved[:, 2:].clamp_min(SMALLEST)


def _rays(pixels: Tensor, K: Tensor) -> Tensor:
    homogeneous = torch.cat([pixels, torch.ones_like(pixels[..., :1])], dim=-1)
    rays = homogeneous @ torch.linalg.inv(K).mT
    return rays[..., :2] / rays[..., 2:]


def _signs(like: Tensor) -> Tensor:
    return torch.from_numpy(CORNER_SIGNS).to(like)
