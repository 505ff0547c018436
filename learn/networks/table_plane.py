"""The plane of the table, fitted to the depth of the pixels that show it.

At the side of a picture that no other view sees nothing can be matched, but the table goes on there. The inverse depth
of a plane is linear in image coordinates, so a fit to what was matched gives it everywhere.
"""

from __future__ import annotations

import torch
from torch import Tensor

#: Residual at which a pixel counts a quarter, in each pass after the first [distances of the planes of the sweep].
_SCALES = (6.0, 3.0, 1.5, 0.75, 0.75)
#: Added to the diagonal of the normal equations, as a fraction of the pixels: without a table the plane is far away.
_RIDGE = 1e-5


def table_plane(inverse: Tensor, weight: Tensor, step: Tensor) -> tuple[Tensor, Tensor]:
    """Return the plane that fits the inverse depth of weighted pixels, by iteratively reweighted least squares.

    Weights fall with the residual r as 1 / (1 + (r / scale)^2)^2, so what stands on the table or lies behind it does
    not tilt the plane. (Geman & McClure's function; Zhang, "Parameter Estimation Techniques: A Tutorial with
    Application to Conic Fitting", 1997, table 1.)

    Parameters
    ----------
    inverse : (B, h, w) Tensor
        Inverse depth [1/m].
    weight : (B, h, w) Tensor
        Probability that a pixel shows the table and was matched, in [0, 1].
    step : (B, 1, 1) Tensor
        Distance of the planes of the sweep [1/m].

    Returns
    -------
    plane : (B, h, w) Tensor
        Inverse depth of the plane at each pixel [1/m]; near 0 without a table.
    support : (B,) Tensor
        Sum of the last weights over the number of pixels: how much of the picture agrees with it.
    """
    height, width = inverse.shape[-2:]
    y, x = torch.meshgrid(
        torch.linspace(-1.0, 1.0, height, device=inverse.device),
        torch.linspace(-1.0, 1.0, width, device=inverse.device),
        indexing="ij",
    )
    basis = torch.stack([x, y, torch.ones_like(x)]).flatten(1)  # (3, h w)
    values, base = inverse.flatten(1), weight.flatten(1)  # (B, h w)
    weights = base
    plane = _fitted(basis, values, weights)
    for scale in _SCALES:
        residual = (plane - values) / (scale * step[:, 0])
        weights = base / (1.0 + residual.square()).square()
        plane = _fitted(basis, values, weights)
    return plane.reshape(inverse.shape), weights.mean(1)


def _fitted(basis: Tensor, values: Tensor, weights: Tensor) -> Tensor:
    """Return the plane of the weighted normal equations at each pixel, (B, h w).

    Solved by cofactors, as ONNX has no solver.
    """
    count = values.shape[1]
    normal = torch.einsum("bn,in,jn->bij", weights, basis, basis) / count
    normal = normal + _RIDGE * torch.eye(3, device=values.device)
    right = torch.einsum("bn,in,bn->bi", weights, basis, values) / count
    first, second, third = normal.unbind(1)
    cofactors = torch.stack(
        [torch.linalg.cross(second, third), torch.linalg.cross(third, first), torch.linalg.cross(first, second)], dim=1
    )
    determinant = (first * cofactors[:, 0]).sum(1)
    return torch.einsum("bi,bij,jn->bn", right, cofactors, basis) / determinant[:, None]
