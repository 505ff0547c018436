"""What both networks take."""

from __future__ import annotations

from torch import Tensor

from ...core.errors import InputError

#: The last features are at this fraction of the picture's size.
MULTIPLE = 32


def check_inputs(images: Tensor, world_T_camera: Tensor, K: Tensor) -> None:
    """Raise InputError where pictures and cameras have not the shapes that a network takes.

    Parameters
    ----------
    images : (B, V, 3, H, W) Tensor
        V is 2 or more; H and W are multiples of 32.
    world_T_camera : (B, V, 4, 4) Tensor
        Poses.
    K : (B, V, 3, 3) Tensor
        Intrinsic matrices.
    """
    if images.ndim != 5 or images.shape[2] != 3:
        raise InputError("images", "shape (B, V, 3, H, W)", tuple(images.shape))
    batch, views, _, height, width = images.shape
    if views < 2:
        raise InputError("images", "two views or more", views)
    if height % MULTIPLE or width % MULTIPLE:
        raise InputError("images", f"a height and a width that are multiples of {MULTIPLE} px", f"{height} x {width}")
    if world_T_camera.shape != (batch, views, 4, 4):
        raise InputError("world_T_camera", f"shape {(batch, views, 4, 4)}", tuple(world_T_camera.shape))
    if K.shape != (batch, views, 3, 3):
        raise InputError("K", f"shape {(batch, views, 3, 3)}", tuple(K.shape))
