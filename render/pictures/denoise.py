"""Denoising with Open Image Denoise, and the blend that keeps what has less noise than the denoiser has bias.

`pyoidn` is imported where it is used: it imports torch where that is installed, which takes seconds.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import cv2
import numpy as np

if TYPE_CHECKING:
    import pyoidn

#: Standard deviation of the window in which noise and the denoiser's changes are compared [px], and its half-width.
_BLEND_SIGMA, _BLEND_REACH = 2.5, 7
#: Standard deviation of the window in which the mean of glass is kept [px].
_MEAN_SIGMA = 8.0
#: Fraction that black pixels have of what is returned to glass, over the window's mean luminance [1]: without one, a
#: glint beside black glass would stay where it was.
_FLAT = 0.1
#: Nothing lies beyond a border: only then is the sum of a window's weights the same from both sides.
_ZERO_BORDER = cv2.BORDER_CONSTANT
#: Factor on the noise in the weight [1]. The denoised picture keeps a part of the noise, which makes the difference
#: smaller. Measured on glass of eight pictures at 32 samples (seeds 101, 103, 107): PSNR 0.6 dB higher where the noise
#: is high than with 1, and 0.1 to 0.5 dB lower where it is low.
_NOISE_FACTOR = 2.0
#: Weights of the channels in the comparison [1]: linear Rec.709 luminance.
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)


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
    import pyoidn

    images = {
        pyoidn.OIDN_IMAGE_COLOR: colour,
        pyoidn.OIDN_IMAGE_ALBEDO: albedo,
        pyoidn.OIDN_IMAGE_NORMAL: normal,
    }
    images = {name: np.ascontiguousarray(image, dtype=np.float32) for name, image in images.items()}
    result = np.zeros_like(images[pyoidn.OIDN_IMAGE_COLOR])
    run_filter(pyoidn.OIDN_FILTER_TYPE_RT, {**images, pyoidn.OIDN_IMAGE_OUTPUT: result}, hdr=True, cleanAux=True)
    return result


def blend(noisy: np.ndarray, variance: np.ndarray, clean: np.ndarray) -> np.ndarray:
    """Return the mean of the noisy and the denoised picture that has the least expected squared error.

    The noisy picture has the known variance v and no bias, the denoised one the unknown bias b and little variance. The
    mean of their squared difference is about v + b^2, so the best weight of the denoised picture is v / (v + b^2). Both
    are averaged over a window. A caustic that the denoiser removes is far above the noise, and stays; noise that it
    removes is all of the difference, and goes.

    Parameters
    ----------
    noisy, variance, clean : (H, W, 3) float32
        Noisy picture, the estimated variance of its values, and the denoised picture.

    Returns
    -------
    (H, W, 3) float32
        The weight is the same for the three channels of a pixel.
    """
    noise = _NOISE_FACTOR * _averaged(variance @ np.square(_LUMINANCE))
    difference = _averaged(np.square((clean - noisy) @ _LUMINANCE))
    weight = np.divide(noise, difference, out=np.ones_like(noise), where=difference > noise)
    return noisy + weight[..., None] * (clean - noisy)


def with_mean_of(noisy: np.ndarray, clean: np.ndarray, inside: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Return a denoised picture with the noisy one's light in wide windows of each part, and so in all of it.

    The denoiser is biased where it has little to go by: it takes up to some per cent of the light off glass, and all of
    a glint. The mean of the noisy picture is right, and over some hundred pixels nearly without noise. What differs is
    returned around where it was, in proportion to the light that is there: a dark drink stays dark beside a lit rim.

    Parameters
    ----------
    noisy, clean : (H, W, 3) float32
        Both pictures.
    inside : (H, W) bool
        The pixels that are corrected; others are not changed, and do not count.
    parts : (H, W) int
        The part of an object that each pixel shows. No light passes from one to another.
    """
    result = clean.copy()
    for number in np.unique(parts[inside]):
        pixels = inside & (parts == number)
        rows, columns = (np.flatnonzero(pixels.any(axis=axis)) for axis in (1, 0))
        part = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
        mask = pixels[part][..., None].astype(np.float32)
        result[part] += _returned(noisy[part], clean[part], mask)
    return np.maximum(result, 0.0)


def _returned(noisy: np.ndarray, clean: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Return what the pixels of a mask, (H, W, 1), get back, (H, W, 3); its sum is that of noisy less clean."""
    level = _window(mask * (clean @ _LUMINANCE)[..., None]) / np.maximum(_window(mask), 1e-6)
    weight = mask * (np.maximum(clean, 0.0) + _FLAT * level + 1e-12)
    # Divided before it is spread, by a symmetric window: the sum stays.
    return weight * _window(mask * (noisy - clean) / np.maximum(_window(weight), 1e-20))


def _window(values: np.ndarray) -> np.ndarray:
    blurred = cv2.GaussianBlur(np.ascontiguousarray(values, np.float32), (0, 0), _MEAN_SIGMA, borderType=_ZERO_BORDER)
    return blurred.reshape(values.shape)


def _averaged(values: np.ndarray) -> np.ndarray:
    side = 2 * _BLEND_REACH + 1
    return cv2.GaussianBlur(np.ascontiguousarray(values, np.float32), (side, side), _BLEND_SIGMA)


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
    import pyoidn

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
    import pyoidn

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
