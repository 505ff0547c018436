"""Files of a polarisation camera: ``stokes.exr``, ``dolp.png``, ``aolp.png``, ``polarisation_mosaic.png``.

``stokes.exr`` has ``S0.R,G,B`` to ``S3.R,G,B``, the Stokes vectors in linear Rec.709 radiance, and ``error.S0`` to
``error.S3``, the standard errors of their luminance.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...core.polarisation import angle_of_linear_polarisation, degree_of_linear_polarisation
from ...core.randomness import stream
from ...procedural.description.scene import Scene
from ...procedural.surroundings.colour import luminance
from ...render.frame import Frame, StokesPicture
from ..polarisation_cameras.mosaic import reported
from . import layout
from .camera_file import PolarisationRecord
from .exr import channel, read_exr, stacked, unstacked, write_exr
from .pictures import stored_radiance, write_png

#: Value of the degree 1 in ``dolp.png``.
DEGREE_STEPS = 65535
#: Value that the angle pi would have in ``aolp.png``; it is 0 again.
ANGLE_STEPS = 65536
_COMPONENTS = ("S0", "S1", "S2", "S3")


def write_polarisation(folder: Path, scene: Scene, frame: Frame) -> PolarisationRecord | None:
    """Write the files of a view's polarisation camera, and return its record; None where the scene has none.

    Parameters
    ----------
    folder : Path
        The view's folder.
    scene, frame : Scene, Frame
        The scene, and the rendered view.
    """
    device, found = scene.polarisation_camera, frame.stokes
    if device is None or found is None:
        return None
    exposure = scene.cameras[frame.view].exposure
    write_stokes(folder / layout.STOKES, found, exposure)
    # Of what the file says, so that they can be made from it again.
    kept = read_stokes(folder / layout.STOKES).vector
    degree, angle = polarisation_numbers(kept)
    write_png(folder / layout.DOLP, degree)
    write_png(folder / layout.AOLP, angle)
    gain = exposure * device.exposure
    rng = stream(scene.seed, scene.scene_id, f"sensors/{frame.view}/polarisation")
    write_png(folder / layout.MOSAIC, reported(device, kept, gain, rng))
    return PolarisationRecord(
        name=device.name,
        angles=device.angles,
        colour=device.colour,
        extinction_ratio=device.extinction_ratio,
        bits=device.bits,
        black_level=device.black_level,
        gain=gain,
    )


def polarisation_numbers(vector: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return what ``dolp.png`` and ``aolp.png`` hold of Stokes vectors, each (H, W) uint16: those of their luminance.

    Parameters
    ----------
    vector : (H, W, 4, 3) float32
        Stokes vectors in linear Rec.709.
    """
    light = luminance(vector)[..., None]
    degree = np.clip(degree_of_linear_polarisation(light)[..., 0], 0.0, 1.0)
    angle = angle_of_linear_polarisation(light)[..., 0]
    steps = np.rint(angle / np.pi * ANGLE_STEPS).astype(np.int64) % ANGLE_STEPS
    return np.rint(degree * DEGREE_STEPS).astype(np.uint16), steps.astype(np.uint16)


def write_stokes(path: Path, stokes: StokesPicture, exposure: float) -> None:
    """Write ``stokes.exr``; with half floats where these are as good (`pictures.stored_radiance`)."""
    vector = stokes.vector
    whole = stored_radiance(vector.reshape(len(vector), -1, 3), exposure).reshape(vector.shape)
    channels = {f"error.{name}": stokes.error[..., k].astype(np.float16) for k, name in enumerate(_COMPONENTS)}
    for k, name in enumerate(_COMPONENTS):
        channels |= unstacked(whole[..., k, :], f"{name}.RGB")
    write_exr(path, channels)


def read_stokes(path: Path) -> StokesPicture:
    """Read ``stokes.exr``; InputError where it is missing or damaged."""
    channels = read_exr(path)
    vector = np.stack([stacked(channels, f"{name}.RGB", path) for name in _COMPONENTS], axis=-2)
    error = np.stack([channel(channels, f"error.{name}", path) for name in _COMPONENTS], axis=-1)
    return StokesPicture(vector=vector.astype(np.float32), error=error.astype(np.float32))
