"""What lies beyond the table: drawn from a seed, and baked to one map of radiance."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np

from ...core.assets import asset
from ..description.surroundings import ConstantEnvironment, Environment, PictureEnvironment, RoomEnvironment
from .hdri import hdri_files, read_hdri
from .room_map import bake_room
from .rooms import draw_room
from .settings import EnvironmentSettings
from .skies import bake_sky, draw_sky

#: Standard deviation of the blur of procedural maps [texel]. At 1 a straight edge is free of stairs to the eye.
_SOFTNESS = 1.0

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
        Shares.
    files : sequence of Path, optional
        The environment maps to draw from; by default those in ``settings.hdri_dir``.

    Raises
    ------
    InputError
        Where the folder is missing or has no environment map.
    """
    if files is None:
        files = () if settings.hdri_dir is None else hdri_files(settings.hdri_dir)
    from_file, indoors = rng.uniform() < settings.hdri_share, rng.uniform() < settings.room_share
    if files and from_file:
        chosen = asset(files[int(rng.integers(len(files)))])
        return PictureEnvironment(asset=chosen, rotation=float(rng.uniform(0.0, 2.0 * np.pi)))
    return draw_room(rng) if indoors else draw_sky(rng)


def bake_environment(environment: Environment, height: int = 512) -> np.ndarray:
    """Return the radiance of an environment by direction, without its ``rotation`` and ``strength``.

    Both are left to the renderer, which applies them exactly; a rotation of pixels would blur the map. The turn is
    counter-clockwise about +z: what is baked at azimuth phi belongs at phi + rotation.

    Parameters
    ----------
    environment : Environment
        A room, a sky, a file or a constant.
    height : int
        Rows of a room's or a sky's map; a file keeps its own size, and a constant needs few.

    Returns
    -------
    (h, 2 * h, 3) float32
        Linear Rec.709, laid out as `sphere` says; read-only, because the last map is remembered (the meter and the
        renderer both ask for it).
    """
    return _baked(environment, height)  # pyright: ignore[reportArgumentType]  # frozen models are hashable at run time


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
    sharp = (
        bake_room(environment, height) if isinstance(environment, RoomEnvironment) else bake_sky(environment, height)
    )
    return _softened(sharp)


def _softened(pixels: np.ndarray) -> np.ndarray:
    """Return a map whose edges are soft over a texel or two, as those of a background out of focus.

    A camera sees a texel over several pixels. Edges that are sharp to one texel then show as stairs.
    """
    margin = 4 * int(np.ceil(_SOFTNESS))
    wrapped = np.concatenate([pixels[:, -margin:], pixels, pixels[:, :margin]], axis=1)
    soft = cv2.GaussianBlur(wrapped, (0, 0), _SOFTNESS, borderType=cv2.BORDER_REPLICATE)
    return np.ascontiguousarray(soft[:, margin:-margin])
