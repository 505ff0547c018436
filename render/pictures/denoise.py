"""Denoising: the firefly filter, and Open Image Denoise with albedo and normal guides.

Fireflies are isolated pixels that a single path made bright. Light that reaches a pixel by rare paths (a caustic seen
in a mirror, a lamp seen through two glasses) arrives in few bright samples. The mean over all pixels is right, and
clamping such samples would darken the picture (bias). So the excess is not clamped but spread over the surrounding
pixels, which the same rare paths reach as well: the mean stays, and the denoiser can handle the result. Pixels that are
bright in every group of samples are not changed.
"""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
import pyoidn

#: Smallest relative standard error of a firefly [1]. It is 1 where one group of samples carries all light, for any
#: number of groups, and 0.6 where 63 to 70 % of the light is in one group (of sixteen, of four).
MIN_RELATIVE_ERROR = 0.6
#: Smallest ratio of a firefly to the median of its neighbourhood [1].
MIN_CONTRAST = 3.0
#: Side of the square that the median is taken over [px].
MEDIAN_SIDE = 5
#: Side of the square that the excess is spread over, as a fraction of the picture's width [1]: so wide that the
#: denoiser does not take it for a detail. Measured on `bench/quality.py --scenes hdri --spp 16`, 240 px wide: relMSE
#: after denoising 0.036 with a square of 5 px, 0.013 with one of 33; without the filter 0.013 as well, but the denoiser
#: lost 1.6 % of the light.
SPREAD = 1 / 8


def spread_fireflies(radiance: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """Return the picture with the excess of fireflies spread over their neighbourhood; its mean stays.

    Parameters
    ----------
    radiance : (H, W, 3) float32
        Noisy picture.
    variance : (H, W, 3) float32
        Estimated variance of each value.
    """
    level = radiance.mean(axis=2)
    around = cv2.medianBlur(np.ascontiguousarray(level, np.float32), MEDIAN_SIDE)
    # The variance of the mean colour is at most that of fully correlated channels, as those of a firefly are.
    error = np.sqrt(variance).mean(axis=2)
    is_firefly = (error >= MIN_RELATIVE_ERROR * level) & (level > MIN_CONTRAST * around)
    kept = np.divide(around, level, out=np.ones_like(level), where=is_firefly)[..., None]
    excess = (radiance * (1.0 - kept)).astype(np.float32)
    return (radiance * kept + box_filtered(excess, SPREAD * excess.shape[1])).astype(np.float32)


def box_filtered(image: np.ndarray, width: float) -> np.ndarray:
    """Return a picture filtered with a box whose weights are normalised inside the picture; its sum stays.

    Parameters
    ----------
    image : (H, W, 3) float32
        The picture.
    width : float
        Side of the box [px], rounded to an odd number.
    """
    side = 2 * int(width / 2) + 1
    ones = np.ones(image.shape[:2], np.float32)
    inside = cv2.boxFilter(ones, -1, (side, side), borderType=cv2.BORDER_CONSTANT)
    return cv2.boxFilter(image / inside[..., None], -1, (side, side), borderType=cv2.BORDER_CONSTANT)


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
