"""A network's outputs to the objects of each view."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import torch
from torch import Tensor

from ..targets.encoding import (
    CORRECTED,
    Encoding,
    decoded_covariance,
    decoded_depth,
    decoded_vertices,
)
from ..targets.fields import STRIDE
from .boxes import boxes_from_fields
from .masks import pixel_owners
from .peaks import Peaks, find_peaks

#: A weaker object whose corners' box in the picture overlaps a stronger one's by more than this is the same object (the
#: released code's value).
SAME = 0.75


@dataclass(frozen=True, eq=False)
class Detections:
    """The objects found in one view, by falling score."""

    score: Tensor  #: (n,) float32
    peak: Tensor  #: (n, 2) float32, (x, y) [px]
    camera_T_object: Tensor  #: (n, 4, 4) float64 [m]
    size: Tensor  #: (n, 3) float64 [m]
    mask: Tensor  #: (n, H, W) bool: the pixels whose first surface is the object

    def __len__(self) -> int:
        """Return the number of objects."""
        return len(self.score)


def decode(
    outputs: Mapping[str, Tensor],
    K: Tensor,
    encoding: Encoding = CORRECTED,
) -> list[Detections]:
    """Return the objects of each sample.

    Parameters
    ----------
    outputs : mapping of Tensor
        ``heatmap``, ``vertex``, ``z_centroid``, ``covariance``, ``seg`` and, where the network has it, ``offset``.
    K : (B, 3, 3) Tensor
        Each sample's own intrinsic matrix [px].
    encoding : Encoding
        Units and order of the fields, and which of them rotations come from (`boxes.boxes_from_fields`).

    Returns
    -------
    list of Detections
        One a sample. What lies behind the camera, and what is a stronger object again, is left out.
    """
    size = (outputs["heatmap"].shape[-2], outputs["heatmap"].shape[-1])
    peaks = find_peaks(outputs["heatmap"].float())
    vertices, depth, covariance = _read(outputs, peaks, size, encoding)
    pose, extent = boxes_from_fields(vertices, depth, covariance, K[peaks.sample], encoding.rotation)
    kept = (depth > 0.0) & _strongest(peaks, vertices)
    found = []
    for sample in range(len(K)):
        rows = (kept & (peaks.sample == sample)).nonzero()[:, 0]
        at, corners = peaks.at[rows], vertices[rows]
        owner = pixel_owners({name: value[sample] for name, value in outputs.items()}, at, corners, encoding)
        mask = owner == torch.arange(len(rows), device=owner.device)[:, None, None]
        found.append(Detections(peaks.score[rows], at, pose[rows], extent[rows], mask))
    return found


def _read(
    outputs: Mapping[str, Tensor], peaks: Peaks, size: tuple[int, int], encoding: Encoding
) -> tuple[Tensor, Tensor, Tensor]:
    """Return corners, (n, 8, 2) [px], depth, (n,) [m], and covariance, (n, 3, 3) [m^2], of the cells at peaks."""
    height, width = outputs["vertex"].shape[-2:]
    cells = (peaks.at / STRIDE).round().long()
    column, row = cells[:, 0].clamp_max(width - 1), cells[:, 1].clamp_max(height - 1)
    at = torch.stack([column, row], dim=1).double() * STRIDE
    values = {name: outputs[name] for name in ("vertex", "z_centroid", "covariance")}
    vertex = values["vertex"][peaks.sample, :, row, column].double()
    depth = decoded_depth(values["z_centroid"][peaks.sample, row, column].double(), encoding)
    covariance = decoded_covariance(values["covariance"][peaks.sample, :, row, column].double(), encoding)
    return decoded_vertices(vertex, at, size, encoding), depth, covariance


def _strongest(peaks: Peaks, vertices: Tensor) -> Tensor:
    """Return which objects are no weaker copy of another of their sample, (n,) bool."""
    low, high = vertices.amin(1), vertices.amax(1)
    area = (high - low).prod(1)
    overlap = (torch.minimum(high[:, None], high) - torch.maximum(low[:, None], low)).clamp_min(0.0).prod(2)
    same = (overlap > SAME * (area[:, None] + area - overlap)) & (peaks.sample[:, None] == peaks.sample)
    kept = torch.ones(len(area), dtype=torch.bool, device=area.device)
    for index in range(len(area)):  # stronger ones come first
        kept[index] = not bool((same[index, :index] & kept[:index]).any())
    return kept
