"""Box decoding: pose and size of boxes from their projected corners, the depth of the centre, and a covariance."""

from __future__ import annotations

import itertools
from typing import Literal

import torch
from torch import Tensor

from ...annotate.boxes import CORNER_SIGNS

#: Least side of a box [m].
MIN_SIDE = 1e-3
#: Variances that differ by less than this fraction of their sum count as equal: sides equal to 10 %. Their eigenvectors
#: are arbitrary, so the guess decides the rotation within their plane.
EQUAL_VARIANCE = 0.1
_ORDERS = tuple(itertools.permutations(range(3)))


def boxes_from_fields(
    vertices: Tensor,
    depth: Tensor,
    covariance: Tensor,
    K: Tensor,
    rotation: Literal["covariance", "vertices"] = "covariance",
) -> tuple[Tensor, Tensor]:
    """Return the poses and sizes of boxes.

    The corners alone give a box up to its scale. Their rotation is a guess that gives order and signs to the axes of
    the covariance. The size follows from the covariance along these axes: side^2 / 12 is the variance of a uniform
    density. A size from the corners would be ill-conditioned, as a pixel of error in some of them is a large error
    along the line of sight. Then the centre follows from the corners, rotation, size and depth. With the rotation from
    ``vertices`` alone, as in the released code, the size follows from the corners as well.

    Parameters
    ----------
    vertices : (n, 8, 2) Tensor
        Image coordinates of the corners [px], numbered as in `annotate.boxes.CORNER_SIGNS`.
    depth : (n,) Tensor
        Planar depth of the box centres [m].
    covariance : (n, 3, 3) Tensor
        Covariance of a uniform density in the boxes, camera axes [m^2].
    K : (n, 3, 3) Tensor
        Intrinsic matrices [px].
    rotation : str
        Source of rotation and size: ``covariance``, or ``vertices`` alone.

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
        size = size_from_covariance(covariance.double(), R)
        centre = _centre(rays, R, depth.double(), size)
    else:
        centre, size = _centre_and_size(rays, R, depth.double())
    pose = torch.eye(4, dtype=torch.float64, device=R.device).repeat(len(R), 1, 1)
    pose[:, :3, :3], pose[:, :3, 3] = R, centre
    return pose, size


def rotation_from_vertices(rays: Tensor) -> Tensor:
    """Return the rotation of boxes, (n, 3, 3), from the rays through their corners, (n, 8, 2), as x / z and y / z.

    A corner is c + A sigma with the centre c, the half axes A and the signs sigma of the corner. Each ray gives two
    linear equations x - (x/z) z = 0, so the twelve numbers of c and A are the null vector of a 16 x 12 matrix, up to a
    factor, whose sign puts the box in front of the camera. (EPnP: Lepetit, Moreno-Noguer & Fua, IJCV 2009, section 3,
    with the centre and the axes as control points.) The result is the rotation nearest to the directions of A.
    """
    signs = _signs(rays)
    one = torch.cat([torch.ones_like(signs[:, :1]), signs], dim=1)  # (8, 4): coefficients of c and of A's columns
    zero = torch.zeros(len(rays), 8, 4, dtype=rays.dtype, device=rays.device)
    part = one.expand_as(zero)
    across = torch.cat([part, zero, -rays[..., :1] * part], dim=2)  # (n, 8, 12): equations of x / z
    down = torch.cat([zero, part, -rays[..., 1:] * part], dim=2)  # (n, 8, 12): equations of y / z
    null = torch.linalg.svd(torch.cat([across, down], dim=1)).Vh[:, -1].reshape(-1, 3, 4)
    null = null * torch.where(null[:, 2, :1, None] < 0.0, -1.0, 1.0)
    axes = null[:, :, 1:]
    lengths = axes.norm(dim=1, keepdim=True)
    return nearest_rotation(axes / lengths.clamp_min(torch.finfo(axes.dtype).tiny))


def rotation_from_covariance(covariance: Tensor, guess: Tensor) -> Tensor:
    """Return the rotation whose columns are axes of a covariance, as near to a guess as they allow.

    The eigenvectors U of the covariance are the axes of the box up to their order and signs. For each of the six orders
    the guess is written in U, the elements that mix axes of different variance are set to 0, and the rotation nearest
    to the rest is taken (Schönemann, "A generalized solution of the orthogonal Procrustes problem", 1966). So where all
    variances differ, only signs are chosen; where two are equal, the angle in their plane as well. The order that
    agrees best with the guess is returned.

    Parameters
    ----------
    covariance : (n, 3, 3) Tensor
        Symmetric.
    guess : (n, 3, 3) Tensor
        Rotations, such as those of `rotation_from_vertices`.

    Returns
    -------
    (n, 3, 3) Tensor
    """
    variance, U = torch.linalg.eigh(covariance)
    same_variance = _same_variance(variance)
    orders = torch.tensor(_ORDERS, device=guess.device)
    ordered = guess[:, :, orders].movedim(2, 1)  # (n, 6, 3, 3): columns of the guess in each order
    inside = (U.mT[:, None] @ ordered) * same_variance[:, None]
    found = U[:, None] @ nearest_rotation(inside, sign=torch.linalg.det(U)[:, None] * _parity(orders))
    agreement = (found * ordered).sum((-1, -2))
    best = agreement.argmax(1)
    chosen = found[torch.arange(len(best), device=best.device), best]
    result = torch.empty_like(chosen)
    index = orders[best][:, None].expand(-1, 3, -1)
    return result.scatter(2, index, chosen)


def size_from_covariance(covariance: Tensor, R: Tensor) -> Tensor:
    """Return the sides of boxes, (n, 3) [m], along the columns of rotations: sqrt(12 R_j^T C R_j)."""
    variance = (R * (covariance @ R)).sum(1)
    return (12.0 * variance.clamp_min(0.0)).sqrt().clamp_min(MIN_SIDE)


def nearest_rotation(matrices: Tensor, sign: Tensor | float = 1.0) -> Tensor:
    """Return the nearest orthogonal matrices of matrices (..., 3, 3), with determinants of a given sign (...)."""
    U, _, Vh = torch.linalg.svd(matrices)
    determinant = torch.linalg.det(U) * torch.linalg.det(Vh) * sign
    U = torch.cat([U[..., :2], U[..., 2:] * determinant.sign()[..., None, None]], dim=-1)
    return U @ Vh


def _same_variance(variance: Tensor) -> Tensor:
    """Return which pairs of axes have equal variance, (n, 3, 3) of 0 and 1, of ascending variances, (n, 3)."""
    gap = (variance[:, 1:] - variance[:, :-1]) > EQUAL_VARIANCE * (variance[:, 1:] + variance[:, :-1]).abs()
    group = torch.cat([torch.zeros_like(gap[:, :1]), gap], dim=1).cumsum(1)
    return (group[:, :, None] == group[:, None, :]).to(variance)


def _parity(orders: Tensor) -> Tensor:
    """Return the determinant of each permutation, (6,)."""
    return torch.linalg.det(torch.eye(3, device=orders.device, dtype=torch.float64)[orders]).round()


def _centre(rays: Tensor, R: Tensor, depth: Tensor, size: Tensor) -> Tensor:
    """Return the centres, (n, 3), of boxes of known size: the least squares of `_centre_and_size`, which are means."""
    corners = 0.5 * (_signs(rays) * size[:, None]) @ R.mT  # (n, 8, 3): from the centre
    seen = rays * (depth[:, None] + corners[..., 2])[..., None]
    return torch.cat([(seen - corners[..., :2]).mean(1), depth[:, None]], dim=1)


def _centre_and_size(rays: Tensor, R: Tensor, depth: Tensor) -> tuple[Tensor, Tensor]:
    """Return centre, (n, 3), and size, (n, 3), by least squares over both coordinates of all corners."""
    signs = _signs(rays)
    rows = []
    for axis in (0, 1):
        centre = torch.zeros(len(R), 8, 2, dtype=R.dtype, device=R.device)
        centre[:, :, axis] = 1.0
        # c_axis + sum_j sigma_j s_j / 2 (R_axis,j - ray R_z,j) = ray z
        sides = 0.5 * signs * (R[:, None, axis] - rays[:, :, axis, None] * R[:, None, 2])
        rows.append(torch.cat([centre, sides], dim=2))
    left = torch.cat(rows, dim=1)  # (n, 16, 5): unknowns are x and y of the centre and the three sides
    right = torch.cat([rays[..., 0], rays[..., 1]], dim=1) * depth[:, None]
    solved = torch.linalg.lstsq(left, right[..., None]).solution[..., 0]
    return torch.cat([solved[:, :2], depth[:, None]], dim=1), solved[:, 2:].clamp_min(MIN_SIDE)


def _rays(pixels: Tensor, K: Tensor) -> Tensor:
    """Return x / z and y / z of image coordinates, (n, 8, 2) each."""
    homogeneous = torch.cat([pixels, torch.ones_like(pixels[..., :1])], dim=-1)
    rays = homogeneous @ torch.linalg.inv(K).mT
    return rays[..., :2] / rays[..., 2:]


def _signs(like: Tensor) -> Tensor:
    return torch.from_numpy(CORNER_SIGNS).to(like)
