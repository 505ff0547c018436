"""Which object each pixel belongs to."""

from __future__ import annotations

from collections.abc import Mapping

import torch
from torch import Tensor

from ..targets.encoding import Encoding, decoded_vertices
from ..targets.fields import STRIDE
from ..targets.view import TRANSPARENT


def pixel_owners(outputs: Mapping[str, Tensor], peaks: Tensor, vertices: Tensor, encoding: Encoding) -> Tensor:
    """Return the index of the object of each pixel, (H, W) int64; -1 for none.

    A pixel whose likeliest class is that of an object belongs to the one whose peak is nearest to where its offset
    leads (Cheng et al., "Panoptic-DeepLab", CVPR 2020, section 3.2). A network without offsets has the pixel's cell of
    the vertex field instead: the pixel belongs to the object whose corners are nearest to those.

    Parameters
    ----------
    outputs : mapping of Tensor
        Of one sample: ``seg`` (n, H, W), and ``offset`` (2, H, W) or ``vertex`` (16, H/8, W/8).
    peaks : (m, 2) Tensor
        Peaks (x, y) of its objects [px].
    vertices : (m, 8, 2) Tensor
        Their corners [px].
    encoding : Encoding
        Units and order of the vertex field.
    """
    is_object = outputs["seg"].argmax(0) >= TRANSPARENT
    owner = torch.full_like(is_object, -1, dtype=torch.int64)
    if not len(peaks):
        return owner
    y, x = is_object.nonzero(as_tuple=True)
    if "offset" in outputs:
        height = is_object.shape[0]
        leads = torch.stack([x, y], dim=1) + height * outputs["offset"][:, y, x].T
        owner[y, x] = torch.cdist(leads.double(), peaks.double()).argmin(1)
        return owner
    own = _own_vertices(outputs["vertex"], (is_object.shape[0], is_object.shape[1]), encoding)
    # A cell stands for the pixel that both its coordinates are divided from, so the nearest cell is the rounded one.
    row, column = ((v + STRIDE // 2) // STRIDE for v in (y, x))
    own = own[row.clamp_max(own.shape[0] - 1), column.clamp_max(own.shape[1] - 1)]
    owner[y, x] = torch.cdist(own.flatten(1), vertices.flatten(1)).argmin(1)
    return owner


def _own_vertices(field: Tensor, size: tuple[int, int], encoding: Encoding) -> Tensor:
    """Return the corners that each cell tells, (h, w, 8, 2) [px]."""
    height, width = field.shape[-2:]
    row, column = torch.meshgrid(torch.arange(height), torch.arange(width), indexing="ij")
    at = torch.stack([column, row], dim=-1).reshape(-1, 2).to(field.device).double() * STRIDE
    return decoded_vertices(field.flatten(1).T.double(), at, size, encoding).reshape(height, width, 8, 2)
