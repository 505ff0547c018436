"""Open Image Denoise: a noisy picture and its guides -> a clean picture."""

from __future__ import annotations

from functools import cache

import numpy as np
import pyoidn


def denoise(colour: np.ndarray, albedo: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Return the picture without its noise.

    The guides must be free of noise (`guides.trace_guides`): they are trusted.

    Parameters
    ----------
    colour : (H, W, 3) float32
        Linear radiance.
    albedo : (H, W, 3) float32
        Reflectance guide in [0, 1].
    normal : (H, W, 3) float32
        Normal guide, components in [-1, 1].

    Returns
    -------
    (H, W, 3) float32
        Linear radiance, >= 0.
    """
    images = {
        pyoidn.OIDN_IMAGE_COLOR: colour,
        pyoidn.OIDN_IMAGE_ALBEDO: albedo,
        pyoidn.OIDN_IMAGE_NORMAL: normal,
    }
    images = {name: np.ascontiguousarray(image, dtype=np.float32) for name, image in images.items()}
    result = np.zeros_like(images[pyoidn.OIDN_IMAGE_COLOR])
    with pyoidn.Filter(device(), pyoidn.OIDN_FILTER_TYPE_RT) as task:
        for name, image in (*images.items(), (pyoidn.OIDN_IMAGE_OUTPUT, result)):
            task.set_image(name, image, pyoidn.OIDN_FORMAT_FLOAT3)
        task.set_bool("hdr", True)
        task.set_bool("cleanAux", True)
        task.set_quality(pyoidn.OIDN_QUALITY_HIGH)
        task.commit()
        task.execute()
        check(device())
    return result


@cache
def device() -> pyoidn.Device:
    """Return the device that filters run on."""
    # The CPU device even where there is a GPU: one machine's pictures then equal another's.
    device = pyoidn.Device(pyoidn.OIDN_DEVICE_TYPE_CPU)
    device.commit()
    check(device)
    return device


def check(device: pyoidn.Device) -> None:
    """Raise what the device has to complain of."""
    message = device.get_error()
    if message is not None:
        raise RuntimeError(f"Open Image Denoise: {message}")
