"""Units and order of the fields that the networks give.

All are chosen so that values and errors of one field are about as large as those of another: vertices are given in
fractions of the picture times 100, the covariance in m^2 times 1000, depth z of a box's centre as 100 (z - 1 m). The
loss weights of the released code are for these.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import torch
from torch import Tensor

VERTEX_SCALE, COVARIANCE_SCALE, Z_SCALE = 100.0, 1000.0, 100.0
#: Depth whose value is 0 [m]: about as far as the objects are.
Z_MIDDLE = 1.0
#: Rows and columns of the 6 covariance channels.
COVARIANCE_ROWS, COVARIANCE_COLUMNS = (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)


@dataclass(frozen=True)
class Encoding:
    """How a network's fields are to be read, and how it wants its pictures."""

    corners: tuple[int, ...]  #: our number (`annotate.boxes.CORNER_SIGNS`) of each of its 8 vertices
    depth_sign: float  #: 1 where depth counts forwards, -1 where the camera's z axis points backwards, as Blender's
    rotation: Literal["covariance", "vertices"]  #: what rotations are decoded from
    stretched: bool  #: whether each picture's values are stretched to [0, 1], all channels together

    def covariance_signs(self) -> np.ndarray:
        """Return the sign of each covariance channel against that in OpenCV's axes, (6,)."""
        axes = np.array([1.0, self.depth_sign, self.depth_sign])
        return axes[list(COVARIANCE_ROWS)] * axes[list(COVARIANCE_COLUMNS)]


#: Our own order and axes.
CORRECTED = Encoding(tuple(range(8)), 1.0, "covariance", stretched=False)
#: Blender's: corners go ---, --+, -++, -+-, +--, +-+, +++, ++-, and a camera looks along -z. The released code never
#: reads the covariance that its network learns, and its loader stretches pictures.
REFERENCE = Encoding((0, 4, 6, 2, 1, 5, 7, 3), -1.0, "vertices", stretched=True)


def encoding_of(variant: str) -> Encoding:
    """Return the encoding of a network's variant."""
    return REFERENCE if variant == "reference" else CORRECTED


def encoded_vertices(vertices: np.ndarray, at: np.ndarray, size: tuple[int, int], encoding: Encoding) -> np.ndarray:
    """Return the vertex channels of boxes as seen from pixels.

    For a vertex (u, v) and a pixel (x, y) they are 100 (1/2 - (y - v) / 2H) and 100 (1/2 - (x - u) / 2W), vertex by
    vertex: between 0 and 100 for a vertex that is less than the picture's size away.

    Parameters
    ----------
    vertices : (n, 8, 2) float
        Image coordinates (u, v) of the corners [px], in our order.
    at : (n, 2) float
        The pixels (x, y).
    size : (int, int)
        Height and width of the picture [px].

    Returns
    -------
    (n, 16) float
    """
    height, width = size
    shift = at[:, None] - vertices[:, list(encoding.corners)]
    shares = 0.5 - shift / (2.0 * np.array([width, height]))
    return VERTEX_SCALE * shares[..., ::-1].reshape(-1, 16)


def decoded_vertices(values: Tensor, at: Tensor, size: tuple[int, int], encoding: Encoding) -> Tensor:
    """Return the corners' image coordinates, (n, 8, 2) [px], of channels, (n, 16), at pixels (x, y), (n, 2)."""
    height, width = size
    shares = values.reshape(-1, 8, 2).flip(-1) / VERTEX_SCALE
    found = at[:, None] - (0.5 - shares) * (2.0 * values.new_tensor([width, height]))
    ours = torch.empty_like(found)
    ours[:, list(encoding.corners)] = found
    return ours


def encoded_depth(z: np.ndarray, encoding: Encoding) -> np.ndarray:
    """Return the values of depths [m]."""
    return Z_SCALE * (encoding.depth_sign * z - Z_MIDDLE)


def decoded_depth(values: Tensor, encoding: Encoding) -> Tensor:
    """Return the depths [m] of values."""
    return encoding.depth_sign * (values / Z_SCALE + Z_MIDDLE)


def encoded_covariance(covariance: np.ndarray, encoding: Encoding) -> np.ndarray:
    """Return the six channels, (n, 6), of covariances in OpenCV's camera axes, (n, 3, 3) [m^2]."""
    channels = covariance[:, list(COVARIANCE_ROWS), list(COVARIANCE_COLUMNS)]
    return COVARIANCE_SCALE * channels * encoding.covariance_signs()


def decoded_covariance(values: Tensor, encoding: Encoding) -> Tensor:
    """Return the covariances in OpenCV's camera axes, (n, 3, 3) [m^2], of six channels, (n, 6)."""
    channels = values / COVARIANCE_SCALE * values.new_tensor(encoding.covariance_signs())
    matrices = values.new_zeros(len(values), 3, 3)
    matrices[:, list(COVARIANCE_ROWS), list(COVARIANCE_COLUMNS)] = channels
    matrices[:, list(COVARIANCE_COLUMNS), list(COVARIANCE_ROWS)] = channels
    return matrices
