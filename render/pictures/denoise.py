"""Open Image Denoise: denoises a picture with albedo and normal guides, and runs the light-map filter."""

from __future__ import annotations

from functools import cache

import numpy as np
import pyoidn


def denoise(colour: np.ndarray, albedo: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Return the denoised picture.

    The guides (auxiliary images) must be free of noise (`guides.trace_guides`): the filter runs with ``cleanAux``.

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
    """Run a filter of Open Image Denoise, which writes into the output image.

    Parameters
    ----------
    kind : str
        ``"RT"`` or ``"RTLightmap"``.
    images : dict
        Input and output images by the filter's names for them, (H, W, 3) float32 each, C-contiguous.
    **flags : bool
        Parameters of the filter.

    Raises
    ------
    RuntimeError
        If the filter reports an error.
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
    # The CPU device even on machines with a GPU: pictures are then the same on all machines.
    device = pyoidn.Device(pyoidn.OIDN_DEVICE_TYPE_CPU)
    device.commit()
    _check(device)
    return device


def _check(device: pyoidn.Device) -> None:
    """Raise RuntimeError if the device reports an error."""
    message = device.get_error()
    if message is not None:
        raise RuntimeError(f"Open Image Denoise: {message}")
