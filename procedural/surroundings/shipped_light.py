"""Eight environment maps that ship with the package: a first picture has real light without any download.

They were made by Greg Zaal (HDRI Haven) and are in the public domain (``maps/LICENSE.txt``).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path

import numpy as np

from ...core.assets import asset
from ..description.surroundings import Environment, PictureEnvironment
from .colour import luminance
from .environments import bake_environment
from .metering import irradiance
from .settings import EnvironmentSettings

#: The maps, and the illuminance on a table in each place [klx]: offices and halls by EN 12464-1 (0.2 to 1, more in a
#: studio), lit grounds at night by EN 12464-2 (5 to 20 lx), shade and a veiled sun by daylight (`file_light`), a sun on
#: the horizon 0.5 to 15 (CIE standard skies, from dusk to 10 degrees).
_PLACES = {
    "city": (20.0, 60.0),
    "courtyard": (1.0, 5.0),
    "forest": (5.0, 20.0),
    "interior": (0.2, 1.0),
    "night": (0.005, 0.02),
    "studio": (0.5, 2.0),
    "sunrise": (2.0, 15.0),
    "sunset": (0.5, 5.0),
}
#: Those of them that were taken outdoors by day.
_BY_DAY = ("city", "courtyard", "forest", "sunrise", "sunset")
_LICENCE = "CC0-1.0"


def shipped_maps() -> tuple[Path, ...]:
    """Return the maps in the package, sorted by name."""
    folder = files("glassware.procedural.surroundings").joinpath("maps")
    return tuple(Path(str(folder.joinpath(f"{name}.exr"))) for name in sorted(_PLACES))


def with_shipped_light(
    rng: np.random.Generator,
    settings: EnvironmentSettings,
    environment: Environment,
    maps: Sequence[Path],
) -> Environment:
    """Return a map of the package in place of a drawn room or sky, with the probability `settings.shipped_share`.

    Parameters
    ----------
    rng : numpy.random.Generator
        The stream ``"environment/shipped"``: what else is drawn does not depend on the share.
    settings : EnvironmentSettings
        The share.
    environment : Environment
        What `environments.draw_environment` drew; a file of the user stays.
    maps : sequence of Path
        The maps to draw from, of `shipped_maps`; none leave the environment as it is.
    """
    wanted = rng.uniform() < settings.shipped_share
    if isinstance(environment, PictureEnvironment) or not maps or not wanted:
        return environment
    path = maps[int(rng.integers(len(maps)))]
    item = asset(path).model_copy(update={"licence": _LICENCE})
    drawn = PictureEnvironment(asset=item, rotation=float(rng.uniform(0.0, 2.0 * np.pi)))
    low, high = _PLACES[path.stem]
    level = math.exp(rng.uniform(math.log(low), math.log(high)))
    strength = level / float(luminance(irradiance(bake_environment(drawn), 1.0, ())))
    return drawn.model_copy(update={"strength": strength})


def is_shipped_by_day(environment: Environment) -> bool:
    """Return whether an environment is a map of the package that was taken outdoors by day."""
    if not isinstance(environment, PictureEnvironment):
        return False
    path = Path(environment.asset.path)
    return path.stem in _BY_DAY and path.resolve() in {shipped.resolve() for shipped in shipped_maps()}
