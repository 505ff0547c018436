"""Decode the outputs of a network: heatmap peaks, boxes at them, suppression of duplicates (NMS), masks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import torch
from torch import Tensor

from ..targets.encoding import CORRECTED, Encoding, decoded_covariance, decoded_depth, decoded_vertices
from ..targets.fields import STRIDE
from ..targets.view import TRANSPARENT
from .boxes import boxes_from_fields
from .peaks import Peaks, find_peaks

#: An object with a lower score is a duplicate where its 2D box of corners has a larger IoU than this with another's
#: (from the released code).
DUPLICATE_IOU = 0.75


@dataclass(frozen=True, eq=False)
class Detections:
    """The objects detected in one view, by descending score."""

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
        Intrinsic matrix of each sample [px].
    encoding : Encoding
        Encoding of the fields, and the source of rotations (`boxes.boxes_from_fields`).

    Returns
    -------
    list of Detections
        One per sample, without boxes behind the camera and without duplicates.
    """
    size = (outputs["heatmap"].shape[-2], outputs["heatmap"].shape[-1])
    peaks = find_peaks(outputs["heatmap"].float())
    vertices, depth, covariance = _fields_at_peaks(outputs, peaks, size, encoding)
    pose, extent = boxes_from_fields(vertices, depth, covariance, K[peaks.sample], encoding.rotation)
    kept = (depth > 0.0) & _without_duplicates(peaks, vertices)
    found = []
    for sample in range(len(K)):
        rows = (kept & (peaks.sample == sample)).nonzero()[:, 0]
        peak, corners = peaks.pixel[rows], vertices[rows]
        owner = pixel_owners({name: value[sample] for name, value in outputs.items()}, peak, corners, encoding)
        mask = owner == torch.arange(len(rows), device=owner.device)[:, None, None]
        found.append(Detections(peaks.score[rows], peak, pose[rows], extent[rows], mask))
    return found


def pixel_owners(outputs: Mapping[str, Tensor], peaks: Tensor, vertices: Tensor, encoding: Encoding) -> Tensor:
    """Return the index of the object of each pixel, (H, W) int64; -1 for none.

    A pixel with the class of an object belongs to the object whose peak is nearest to the pixel plus its offset (Cheng
    et al., "Panoptic-DeepLab", CVPR 2020, section 3.2). Without offsets, the pixel's cell of the vertex field is used:
    the pixel belongs to the object with the nearest corners.

    Parameters
    ----------
    outputs : mapping of Tensor
        Of one sample: ``seg`` (n, H, W), and ``offset`` (2, H, W) or ``vertex`` (16, H/8, W/8).
    peaks : (m, 2) Tensor
        Peaks (x, y) of its objects [px].
    vertices : (m, 8, 2) Tensor
        Their corners [px].
    encoding : Encoding
        Encoding of the vertex field.
    """
    is_object = outputs["seg"].argmax(0) >= TRANSPARENT
    owner = torch.full_like(is_object, -1, dtype=torch.int64)
    if not len(peaks):
        return owner
    y, x = is_object.nonzero(as_tuple=True)
    if "offset" in outputs:
        height = is_object.shape[0]
        targets = torch.stack([x, y], dim=1) + height * outputs["offset"][:, y, x].T
        owner[y, x] = torch.cdist(targets.double(), peaks.double()).argmin(1)
        return owner
    per_cell = _cell_vertices(outputs["vertex"], (is_object.shape[0], is_object.shape[1]), encoding)
    # Cell (i, j) stands for pixel (8 i, 8 j), so the nearest cell is the rounded one.
    row, column = ((v + STRIDE // 2) // STRIDE for v in (y, x))
    per_pixel = per_cell[row.clamp_max(per_cell.shape[0] - 1), column.clamp_max(per_cell.shape[1] - 1)]
    owner[y, x] = torch.cdist(per_pixel.flatten(1), vertices.flatten(1)).argmin(1)
    return owner


def _fields_at_peaks(
    outputs: Mapping[str, Tensor], peaks: Peaks, size: tuple[int, int], encoding: Encoding
) -> tuple[Tensor, Tensor, Tensor]:
    """Return corners, (n, 8, 2) [px], depth, (n,) [m], and covariance, (n, 3, 3) [m^2], of the cells at peaks."""
    height, width = outputs["vertex"].shape[-2:]
    cells = (peaks.pixel / STRIDE).round().long()
    column, row = cells[:, 0].clamp_max(width - 1), cells[:, 1].clamp_max(height - 1)
    at = torch.stack([column, row], dim=1).double() * STRIDE
    values = {name: outputs[name] for name in ("vertex", "z_centroid", "covariance")}
    vertex = values["vertex"][peaks.sample, :, row, column].double()
    depth = decoded_depth(values["z_centroid"][peaks.sample, row, column].double(), encoding)
    covariance = decoded_covariance(values["covariance"][peaks.sample, :, row, column].double(), encoding)
    return decoded_vertices(vertex, at, size, encoding), depth, covariance


def _without_duplicates(peaks: Peaks, vertices: Tensor) -> Tensor:
    """Return which objects survive non-maximum suppression within their sample, (n,) bool."""
    low, high = vertices.amin(1), vertices.amax(1)
    area = (high - low).prod(1)
    overlap = (torch.minimum(high[:, None], high) - torch.maximum(low[:, None], low)).clamp_min(0.0).prod(2)
    same = (overlap > DUPLICATE_IOU * (area[:, None] + area - overlap)) & (peaks.sample[:, None] == peaks.sample)
    kept = torch.ones(len(area), dtype=torch.bool, device=area.device)
    for index in range(len(area)):  # by descending score
        kept[index] = not bool((same[index, :index] & kept[:index]).any())
    return kept


def _cell_vertices(field: Tensor, size: tuple[int, int], encoding: Encoding) -> Tensor:
    """Return the corners decoded from each cell, (h, w, 8, 2) [px]."""
    height, width = field.shape[-2:]
    row, column = torch.meshgrid(torch.arange(height), torch.arange(width), indexing="ij")
    at = torch.stack([column, row], dim=-1).reshape(-1, 2).to(field.device).double() * STRIDE
    return decoded_vertices(field.flatten(1).T.double(), at, size, encoding).reshape(height, width, 8, 2)
