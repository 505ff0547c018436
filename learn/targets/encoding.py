"""Encoding of box corners, centre depth and covariance as fields of a network, and decoding of those fields.

The units make the errors of all fields about equally large: vertices are fractions of the image size times 100, the
covariance is in m^2 times 1000, the depth z of a box centre is 100 (z - 1 m). The loss weights of the released code are
for these units.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import torch
from torch import Tensor

from ..networks.settings import NetworkSettings

#: Factors of the vertex field, the covariance [1 / m^2] and the centre depth [1 / m] (the released code's).
VERTEX_SCALE, COVARIANCE_SCALE, Z_SCALE = 100.0, 1000.0, 100.0
#: Depth that is encoded as 0 [m]: about the distance of the objects.
Z_MIDDLE = 1.0
#: Rows and columns of the 6 covariance channels.
COVARIANCE_ROWS, COVARIANCE_COLUMNS = (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)


@dataclass(frozen=True)
class Encoding:
    """Conventions of a network's fields and input images."""

    corners: tuple[int, ...]  #: our number (`annotate.boxes.CORNER_SIGNS`) of each of its 8 vertices
    depth_sign: float  #: 1 where the camera's z axis points forwards (OpenCV), -1 where it points backwards (Blender)
    rotation: Literal["covariance", "vertices"]  #: the fields from which rotations are decoded
    stretch_contrast: bool  #: whether each image is scaled to the range [0, 1], all channels together

    def covariance_signs(self) -> np.ndarray:
        """Return the factors between covariance channels in the network's axes and in OpenCV's, 1 or -1, (6,)."""
        axes = np.array([1.0, self.depth_sign, self.depth_sign])
        return axes[list(COVARIANCE_ROWS)] * axes[list(COVARIANCE_COLUMNS)]


#: Our corner order, OpenCV's axes.
CORRECTED = Encoding(tuple(range(8)), 1.0, "covariance", stretch_contrast=False)
#: Blender's corner order ---, --+, -++, -+-, +--, +-+, +++, ++-, and its camera, which looks along -z. The released
#: code never reads the covariance that its network learns, and its loader stretches the contrast of images.
REFERENCE = Encoding((0, 4, 6, 2, 1, 5, 7, 3), -1.0, "vertices", stretch_contrast=True)


#: Released networks that decode the covariance: the corrected conventions, with the released contrast.
STRETCHED = Encoding(CORRECTED.corners, 1.0, "covariance", stretch_contrast=True)


def encoding_of(settings: NetworkSettings) -> Encoding:
    """Return the encoding of a network."""
    if settings.variant == "corrected" or settings.name in ("keypose", "densefusion"):
        return CORRECTED
    return REFERENCE if settings.name == "mvtrans" else STRETCHED


def encoded_vertices(vertices: np.ndarray, at: np.ndarray, size: tuple[int, int], encoding: Encoding) -> np.ndarray:
    """Return the vertex channels of boxes at pixels.

    For a vertex (u, v) and a pixel (x, y) they are 100 (1/2 - (y - v) / 2H) and 100 (1/2 - (x - u) / 2W), vertex by
    vertex: between 0 and 100 for a vertex that is less than the image size away.

    Parameters
    ----------
    vertices : (n, 8, 2) float
        Image coordinates (u, v) of the corners [px], in the order of `annotate.boxes.CORNER_SIGNS`.
    at : (n, 2) float
        Pixels (x, y).
    size : (int, int)
        Height and width of the image [px].

    Returns
    -------
    (n, 16) float
    """
    height, width = size
    shift = at[:, None] - vertices[:, list(encoding.corners)]
    fractions = 0.5 - shift / (2.0 * np.array([width, height]))
    return VERTEX_SCALE * fractions[..., ::-1].reshape(-1, 16)  # (n, 8, 2) as (y, x) to (n, 16)


def decoded_vertices(values: Tensor, at: Tensor, size: tuple[int, int], encoding: Encoding) -> Tensor:
    """Return the image coordinates of the corners, (n, 8, 2) [px], of channels, (n, 16), at pixels (x, y), (n, 2)."""
    height, width = size
    fractions = values.reshape(-1, 8, 2).flip(-1) / VERTEX_SCALE
    found = at[:, None] - (0.5 - fractions) * (2.0 * values.new_tensor([width, height]))
    vertices = torch.empty_like(found)
    vertices[:, list(encoding.corners)] = found
    return vertices


def encoded_depth(z: np.ndarray, encoding: Encoding) -> np.ndarray:
    """Return the encoded values of depths [m]."""
    return Z_SCALE * (encoding.depth_sign * z - Z_MIDDLE)


def decoded_depth(values: Tensor, encoding: Encoding) -> Tensor:
    """Return the depths [m] of encoded values."""
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
