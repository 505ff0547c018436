"""A rotation from a covariance, whose axes have neither order nor sign, and a guess that has both."""

from __future__ import annotations

import itertools

import torch
from torch import Tensor

#: Two variances that differ by less than this share of their sum have no axes of their own: a body as wide as deep, to
#: 10 %. The guess decides within their plane.
EQUAL = 0.1
_ORDERS = tuple(itertools.permutations(range(3)))


def rotation_from_covariance(covariance: Tensor, guess: Tensor) -> Tensor:
    """Return the rotation whose columns are axes of a covariance, as near to a guess as these allow.

    The eigenvectors U of the covariance (its SVD, as it is symmetric) are the box's axes up to their order and signs.
    For each of the six orders the guess is written in U; what mixes axes of different variance is left out, and the
    rotation nearest to the rest is taken (Schönemann, "A generalized solution of the orthogonal Procrustes problem",
    1966). So where all variances differ only signs are chosen, and where two are equal the angle in their plane too.
    The order that agrees best with the guess wins.

    Parameters
    ----------
    covariance : (n, 3, 3) Tensor
        Symmetric.
    guess : (n, 3, 3) Tensor
        Rotations, such as those of the boxes from the vertex field.

    Returns
    -------
    (n, 3, 3) Tensor
    """
    variance, U = torch.linalg.eigh(covariance)
    alike = _alike(variance)
    orders = torch.tensor(_ORDERS, device=guess.device)
    ordered = guess[:, :, orders].movedim(2, 1)  # (n, 6, 3, 3): columns of the guess in each order
    inside = (U.mT[:, None] @ ordered) * alike[:, None]
    found = U[:, None] @ nearest_rotation(inside, sign=torch.linalg.det(U)[:, None] * _parity(orders))
    agreement = (found * ordered).sum((-1, -2))
    best = agreement.argmax(1)
    chosen = found[torch.arange(len(best), device=best.device), best]
    result = torch.empty_like(chosen)
    index = orders[best][:, None].expand(-1, 3, -1)
    return result.scatter(2, index, chosen)


def nearest_rotation(matrices: Tensor, sign: Tensor | float = 1.0) -> Tensor:
    """Return the orthogonal matrices nearest to some, (..., 3, 3), with determinants of a given sign (...)."""
    U, _, Vh = torch.linalg.svd(matrices)
    turn = torch.linalg.det(U) * torch.linalg.det(Vh) * sign
    U = torch.cat([U[..., :2], U[..., 2:] * turn.sign()[..., None, None]], dim=-1)
    return U @ Vh


def _alike(variance: Tensor) -> Tensor:
    """Return which axes share a plane, (n, 3, 3) of 0 and 1, of ascending variances, (n, 3)."""
    gap = (variance[:, 1:] - variance[:, :-1]) > EQUAL * (variance[:, 1:] + variance[:, :-1]).abs()
    group = torch.cat([torch.zeros_like(gap[:, :1]), gap], dim=1).cumsum(1)
    return (group[:, :, None] == group[:, None, :]).to(variance)


def _parity(orders: Tensor) -> Tensor:
    """Return the determinant of each permutation, (6,)."""
    return torch.linalg.det(torch.eye(3, device=orders.device, dtype=torch.float64)[orders]).round()
