"""What lies beyond the table: drawn from a seed, and baked to one map of radiance."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np

from ...core.assets import asset
from ..description.surroundings import ConstantEnvironment, Environment, PictureEnvironment, RoomEnvironment
from .file_light import draw_strength
from .hdri import read_hdri, usable_hdris
from .room_map import bake_room
from .rooms import draw_room
from .settings import EnvironmentSettings
from .skies import bake_sky, draw_sky
from .sphere import softened

#: Rows of the map of a constant environment. Any number holds it; few cost nothing.
_CONSTANT_HEIGHT = 8


def draw_environment(
    rng: np.random.Generator, settings: EnvironmentSettings, files: Sequence[Path] | None = None
) -> Environment:
    """Draw the surroundings of a scene: a file, a room or a sky.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of all draws.
    settings : EnvironmentSettings
        Shares, whether files are scaled, and the size of the sun.
    files : sequence of Path, optional
        The environment maps to draw from; by default those in ``settings.hdri_dir``.

    Raises
    ------
    InputError
        Where the folder is missing or has no environment map, or the chosen one cannot be read.
    """
    if files is None:
        files, _ = usable_hdris(settings.hdri_dir)
    from_file, indoors = rng.uniform() < settings.hdri_share, rng.uniform() < settings.room_share
    if files and from_file:
        chosen = asset(files[int(rng.integers(len(files)))])
        environment = PictureEnvironment(asset=chosen, rotation=float(rng.uniform(0.0, 2.0 * np.pi)))
        if settings.hdri_calibrated:
            return environment
        strength = draw_strength(rng, bake_environment(environment))
        return environment.model_copy(update={"strength": strength})
    return draw_room(rng) if indoors else draw_sky(rng, settings.sun_radius)


def bake_environment(environment: Environment, height: int = 512) -> np.ndarray:
    """Return the radiance of an environment by direction, without its ``rotation`` and ``strength``.

    Both are left to the renderer, which applies them exactly; a rotation of pixels would blur the map. The turn is
    counter-clockwise about +z: what is baked at azimuth phi belongs at phi + rotation.

    Parameters
    ----------
    environment : Environment
        A room, a sky, a file or a constant.
    height : int
        Rows of a room's map, and half those of a sky's with a sharp sun; a file keeps its own size, and a constant
        needs few.

    Returns
    -------
    (h, 2 * h, 3) float32
        Linear Rec.709, laid out as `sphere` says; read-only, because the last map is remembered (the meter and the
        renderer both ask for it).
    """
    changes = {"strength": 1.0} | ({} if isinstance(environment, ConstantEnvironment) else {"rotation": 0.0})
    if isinstance(environment, RoomEnvironment):  # small bodies are too small for the map, and do not change it
        changes |= {"details": ()}
    plain = environment.model_copy(update=changes)
    return _baked(plain, height)  # pyright: ignore[reportArgumentType]  # frozen models are hashable at run time


@lru_cache(maxsize=1)
def _baked(environment: Environment, height: int) -> np.ndarray:
    pixels = _fresh(environment, height)
    pixels.setflags(write=False)
    return pixels


def _fresh(environment: Environment, height: int) -> np.ndarray:
    if isinstance(environment, PictureEnvironment):
        return read_hdri(environment.asset)
    if isinstance(environment, ConstantEnvironment):
        return np.full((_CONSTANT_HEIGHT, 2 * _CONSTANT_HEIGHT, 3), environment.radiance, np.float32)
    if isinstance(environment, RoomEnvironment):
        return softened(bake_room(environment, height))
    return bake_sky(environment, height)
