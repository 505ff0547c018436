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
    run_filter(pyoidn.OIDN_FILTER_TYPE_RT, {**images, pyoidn.OIDN_IMAGE_OUTPUT: result}, hdr=True, cleanAux=True)
    return result


def run_filter(kind: str, images: dict[str, np.ndarray], **flags: bool) -> None:
    """Run one of Open Image Denoise's filters; it writes into its output image.

    Parameters
    ----------
    kind : str
        ``"RT"`` or ``"RTLightmap"``.
    images : dict
        Input and output by the filter's names for them, (H, W, 3) float32 each, C-contiguous.
    **flags : bool
        What the filter is told.

    Raises
    ------
    RuntimeError
        With what the filter has to complain of.
    """
    # (Not in a `with` block: the context manager of pyoidn 2.5 returns itself on leaving, which silences all errors.)
    task = pyoidn.Filter(device(), kind)
    try:
        for name, image in images.items():
            task.set_image(name, image, pyoidn.OIDN_FORMAT_FLOAT3)
        for name, flag in flags.items():
            task.set_bool(name, flag)
        task.set_quality(pyoidn.OIDN_QUALITY_HIGH)
        task.commit()
        task.execute()
        _check(device())
    finally:
        task.release()


@cache
def device() -> pyoidn.Device:
    """Return the device that filters run on."""
    # The CPU device even where there is a GPU: one machine's pictures then equal another's.
    device = pyoidn.Device(pyoidn.OIDN_DEVICE_TYPE_CPU)
    device.commit()
    _check(device)
    return device


def _check(device: pyoidn.Device) -> None:
    """Raise what the device has to complain of."""
    message = device.get_error()
    if message is not None:
        raise RuntimeError(f"Open Image Denoise: {message}")
