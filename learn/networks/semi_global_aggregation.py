"""Semi-global aggregation of a cost volume: each plane's least cost along paths from four sides, and where it is least.

(Hirschmüller, "Stereo Processing by Semiglobal Matching and Mutual Information", PAMI 2008, section 2.2.)
"""

from __future__ import annotations

import torch
from torch import Tensor
from torch._higher_order_ops.scan import scan
from torch.nn import functional

#: Added to the curvature of a parabola through three costs, so that a flat one has a lowest point.
_FLAT = 1e-6
#: A jump between pixels whose colours in [0, 1] differ by 1/300, which is a level of 8 bits, costs half. It stays
#: dearer than a step.
_EDGE, _LEAST = 300.0, 1.5


def aggregate(costs: Tensor, image: Tensor, small: float, large: float) -> Tensor:
    """Return the costs of the best paths that reach a pixel from the left, the right, above and below, summed.

    Along a path, ``L(p, d) = C(p, d) + min(L(p - 1, d), L(p - 1, d +- 1) + small, min L(p - 1) + jump) -
    min L(p - 1)`` (eq. 13 there): what has no texture gets its plane from what lies beside it. Depth jumps where
    colours change, so that a jump costs ``max(1.5 small, large / (1 + 300 |difference of colours|))`` (as in eq. 12).

    Parameters
    ----------
    costs : (N, h, w, D) Tensor
        Matching costs; the planes are the last axis, so that a step along a path reads consecutive memory.
    image : (N, h, w, 3) Tensor
        Colours in [0, 1].
    small, large : float
        Cost of a step to the next plane, and of one to any plane where colours are the same, in units of the costs;
        0 < small < large.

    Returns
    -------
    (N, h, w, D) Tensor
    """
    sums = []
    for axis in (1, 2):
        lines, jumps = costs.movedim(axis, 0), _jumps(image.movedim(axis, 0), small, large)
        both = _along(lines, jumps, small, False) + _along(lines, jumps.roll(-1, 0), small, True)
        sums.append(both.movedim(0, axis))
    return sums[0] + sums[1]


def _jumps(lines: Tensor, small: float, large: float) -> Tensor:
    """Return the cost of a jump from the line before, (n, N, m, 1), for the lines of an image, (n, N, m, 3)."""
    difference = (lines - lines.roll(1, 0)).abs().mean(-1, keepdim=True)  # none comes before the first: not used
    return (large / (1.0 + _EDGE * difference)).clamp_min(_LEAST * small)


def _along(lines: Tensor, jumps: Tensor, small: float, backwards: bool) -> Tensor:
    """Return the costs of the best paths through the lines of an image, (n, N, m, D), from the first or the last."""
    if torch.compiler.is_exporting():  # one node of ONNX, where the loop would be thousands
        return _scanned(lines, jumps, small, backwards)
    order = range(len(lines) - 1, -1, -1) if backwards else range(len(lines))
    paths, last = [torch.empty(0)] * len(lines), torch.zeros_like(lines[0])
    for index in order:
        paths[index] = last = _next(last, lines[index], jumps[index], small)
    return torch.stack(paths)


def _scanned(lines: Tensor, jumps: Tensor, small: float, backwards: bool) -> Tensor:
    def combine(last: Tensor, line: tuple[Tensor, Tensor]) -> tuple[Tensor, Tensor]:
        path = _next(last, *line, small)
        return path, path.clone()  # what is carried on and what is kept must not share memory

    return scan(combine, torch.zeros_like(lines[0]), (lines, jumps), dim=0, reverse=backwards)[1]


def _next(last: Tensor, line: Tensor, jump: Tensor, small: float) -> Tensor:
    """Return the costs of the best paths to a line, (N, m, D), of those to the line before; zeros before the first."""
    least = last.amin(-1, keepdim=True)
    # Beyond the ends stands the cost of the end itself, which a step makes greater: it has no effect.
    beside = functional.pad(last, (1, 1), mode="replicate")
    step = torch.minimum(beside[..., :-2], beside[..., 2:]) + small
    return line + torch.minimum(torch.minimum(step, last), least + jump) - least


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
