"""Semi-global aggregation of a cost volume: each plane's least cost along paths from four sides, and where it is least.

(Hirschmüller, "Stereo Processing by Semiglobal Matching and Mutual Information", PAMI 2008, section 2.2.)
"""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor
from torch.nn import functional

#: Added to the curvature of a parabola through three costs, so that a flat one has a lowest point.
_FLAT = 1e-6


def aggregate(costs: Tensor, small: float, large: float) -> Tensor:
    """Return the costs of the best paths that reach a pixel from the left, the right, above and below, summed.

    Along a path, ``L(p, d) = C(p, d) + min(L(p - 1, d), L(p - 1, d +- 1) + small, min L(p - 1) + large) -
    min L(p - 1)`` (eq. 13 there): what has no texture gets its plane from what lies beside it.

    Parameters
    ----------
    costs : (N, h, w, D) Tensor
        Matching costs; the planes are the last axis, so that a step along a path reads consecutive memory.
    small, large : float
        Cost of a step to the next plane, and of one to any plane, in units of the costs; 0 < small < large.

    Returns
    -------
    (N, h, w, D) Tensor
    """
    sums = []
    for axis in (1, 2):
        lines = costs.unbind(axis)
        ahead, back = _along(lines, small, large), _along(lines[::-1], small, large)[::-1]
        sums.append(torch.stack([first + second for first, second in zip(ahead, back, strict=True)], axis))
    return sums[0] + sums[1]


def _along(lines: Sequence[Tensor], small: float, large: float) -> list[Tensor]:
    """Return the costs of the best paths through the lines of an image, each (N, m, D), in order."""
    paths = [lines[0]]
    for line in lines[1:]:
        last = paths[-1]
        least = last.amin(-1, keepdim=True)
        # Beyond the ends stands the cost of the end itself, which a step makes greater: it has no effect.
        beside = functional.pad(last, (1, 1), mode="replicate")
        step = torch.minimum(beside[..., :-2], beside[..., 2:]) + small
        paths.append(line + torch.minimum(torch.minimum(step, last), least + large) - least)
    return paths


def lowest(costs: Tensor) -> Tensor:
    """Return the plane of least cost, (N, h, w), with fractions from the parabola through it and its neighbours.

    Parameters
    ----------
    costs : (N, h, w, D) Tensor
        D is 3 or more; the first and the last plane count as the ones next to them.
    """
    plane = costs.argmin(-1, keepdim=True).clamp(1, costs.shape[-1] - 2)
    before, here, after = (costs.gather(-1, plane + offset)[..., 0] for offset in (-1, 0, 1))
    fraction = (before - after) / (2.0 * (before - 2.0 * here + after)).clamp_min(_FLAT)
    return plane[..., 0] + fraction.clamp(-0.5, 0.5)
