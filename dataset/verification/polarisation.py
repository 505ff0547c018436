"""A polarisation camera's files: vectors that light can have, pictures and mosaic that follow, and the same light."""

from __future__ import annotations

import numpy as np

from ...core.polarisation import angle_of_linear_polarisation, degree_of_linear_polarisation
from ...procedural.description.polarisation_camera import PolarisationCamera
from ...procedural.description.scene import Scene
from ...render.frame import Geometry, StokesPicture
from ..format import layout
from ..format.camera_file import PolarisationRecord
from ..format.polarisation_files import ANGLE_STEPS, DEGREE_STEPS
from ..format.sensor_files import read_numbers
from ..polarisation_cameras.mosaic import filtered_light, reported_variance, signal_of
from ..stored_view import StoredView
from .fault import Fault, at_pixels, unlike

#: Weights of linear Rec.709 in luminance (ITU-R BT.709-6).
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
#: Rounding of half floats, 2^-11 for each of four components, in the degree of polarisation [1].
ROUNDING = 2e-3
#: Rounding of the numbers of ``dolp.png`` and ``aolp.png``, and of the halves' in luminance, in steps [1].
STEPS = 2
#: Standard deviations of the mean of a mosaic that chance does not give in any data set [1].
SIGMAS = 6.0
#: Largest mean square of such deviations [1]; it is 1 within a few hundredths.
MOST_VARIANCE = 1.5
#: Largest difference of the mean light on opaque surfaces from the picture's beyond noise [1]: the picture may read an
#: irradiance cache, and the denoiser is not exact.
SAME_LIGHT = 0.05
#: Fewest such pixels that are compared [px].
FEWEST = 500


def polarisation_faults(view: StoredView, scene: Scene, geometry: Geometry) -> list[Fault]:
    """Check the files of a view's polarisation camera.

    Parameters
    ----------
    view : StoredView
        The view.
    scene : Scene
        Its scene.
    geometry : Geometry
        What the left camera sees.
    """
    device, record = scene.polarisation_camera, view.polarisation_camera()
    if device is None or record is None:
        expected, stored = (None if one is None else one.name for one in (device, record))
        return unlike("polarisation", layout.CAMERA, "polarisation_camera", expected, stored)
    gain = scene.cameras[view.number].exposure * device.exposure
    found = record_faults(record, device, gain)
    stokes = view.stokes()
    if stokes.vector.shape[:2] != geometry.Z.shape:
        size = str(stokes.vector.shape[:2])
        return [*found, Fault("polarisation", layout.STOKES, "size", str(geometry.Z.shape), size)]
    found = found or vector_faults(stokes.vector, scene.picture.spectral)
    if found:
        return found
    found = [*_picture_faults(view, stokes.vector), *_mosaic_faults(view, device, stokes.vector, gain)]
    return found + _light_faults(view, stokes, geometry, scene)


def record_faults(record: PolarisationRecord, device: PolarisationCamera, gain: float) -> list[Fault]:
    """Compare the record of a polarisation camera with the scene's device, and its gain with the exposure."""
    found: list[Fault] = []
    for name in ("name", "colour", "bits"):
        where = f"polarisation_camera {name}"
        found += unlike("polarisation", layout.CAMERA, where, str(getattr(device, name)), str(getattr(record, name)))
    numbers = {"angles": device.angles, "extinction_ratio": device.extinction_ratio, "black_level": device.black_level}
    for name, expected in (numbers | {"gain": gain}).items():
        where, stored = f"polarisation_camera {name}", getattr(record, name)
        found += unlike("polarisation", layout.CAMERA, where, expected, stored, 1e-9 * float(np.abs(expected).max()))
    return found


def vector_faults(vector: np.ndarray, spectral: bool) -> list[Fault]:
    """Check that vectors are those of light: finite, and s0 at least as long as (s1, s2, s3).

    Red, green and blue of wavelengths are differences, for which that holds of the luminance alone.
    """
    light = (vector @ _LUMINANCE)[..., None] if spectral else vector
    damaged = np.asarray(~np.isfinite(vector).all((-1, -2)))
    found = at_pixels("polarisation", layout.STOKES, damaged, "finite numbers", vector)
    if found:
        return found
    s0, length = light[..., 0, :], np.sqrt((light[..., 1:, :].astype(np.float64) ** 2).sum(-2))
    wrong = (length > s0 * (1.0 + ROUNDING)).any(-1)
    return at_pixels("polarisation", layout.STOKES, wrong, "S0 of at least sqrt(S1^2 + S2^2 + S3^2)", vector)


def _picture_faults(view: StoredView, vector: np.ndarray) -> list[Fault]:
    """Compare degree and angle with those of the vectors."""
    light = (vector @ _LUMINANCE)[..., None]
    degree, angle = (f(light)[..., 0] for f in (degree_of_linear_polarisation, angle_of_linear_polarisation))
    stored = {name: read_numbers(view.folder / name).astype(np.float64) for name in (layout.DOLP, layout.AOLP)}
    found: list[Fault] = []
    apart = {
        layout.DOLP: np.abs(stored[layout.DOLP] - DEGREE_STEPS * np.clip(degree, 0.0, 1.0)),
        # As angles on a circle.
        layout.AOLP: np.abs((stored[layout.AOLP] - ANGLE_STEPS * angle / np.pi + 0.5 * ANGLE_STEPS) % ANGLE_STEPS)
        - 0.5 * ANGLE_STEPS,
    }
    for name, steps in apart.items():
        wrong = np.abs(steps) > STEPS
        if name == layout.AOLP:  # unpolarised light has any angle
            wrong &= degree > ROUNDING
        found += at_pixels("polarisation", name, wrong, f"that of {layout.STOKES}", stored[name])
    return found


def _mosaic_faults(view: StoredView, device: PolarisationCamera, vector: np.ndarray, gain: float) -> list[Fault]:
    """Compare the mosaic with what its filters let through: noise has no mean, and a known spread."""
    numbers = view.polarisation_mosaic()
    wrong = numbers > 2**device.bits - 1
    found = at_pixels("polarisation", layout.MOSAIC, wrong, f"a number of {device.bits} bits", numbers)
    if found or numbers.shape != vector.shape[:2]:
        return found or unlike("polarisation", layout.MOSAIC, "size", str(vector.shape[:2]), str(numbers.shape))
    signal, light = signal_of(numbers, device.bits, device.black_level), filtered_light(device, vector) * gain
    deviation = np.sqrt(reported_variance(device, light))
    # Far from black and from saturation, where noise is cut off.
    usual = (light > SIGMAS * deviation) & (light < 1.0 - SIGMAS * deviation)
    score = (signal - light)[usual] / deviation[usual]
    if score.size < FEWEST:
        return []
    total = float(abs(score.sum()) / np.sqrt(score.size))
    if total <= SIGMAS and float((score**2).mean()) <= MOST_VARIANCE:
        return []
    expected = f"the light behind its filters, within {SIGMAS:g} standard errors"
    return [Fault("polarisation", layout.MOSAIC, f"{score.size} px", expected, f"{total:.3g}")]


def _light_faults(view: StoredView, stokes: StokesPicture, geometry: Geometry, scene: Scene) -> list[Fault]:
    """Compare S0 on opaque surfaces with the radiance of the left picture, where that is stored."""
    if not (view.folder / "left.exr").is_file():
        return []
    opaque = np.isfinite(geometry.Z) & ~np.isin(geometry.id, [body.id for body in scene.vessels])
    if np.count_nonzero(opaque) < FEWEST:
        return []
    light, picture = (x[opaque] @ _LUMINANCE for x in (stokes.vector[..., 0, :], view.radiance("left")))
    noise = SIGMAS * float(np.sqrt((stokes.error[..., 0][opaque].astype(np.float64) ** 2).sum())) / light.size
    if abs(float(light.mean() - picture.mean())) <= SAME_LIGHT * float(picture.mean()) + noise:
        return []
    where, expected = f"mean of {light.size} px of opaque things", f"{picture.mean():.4g}, as in left.exr"
    return [Fault("polarisation", layout.STOKES, where, expected, f"{light.mean():.4g}")]
