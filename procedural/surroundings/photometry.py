"""What a light meter and a luminance meter would read in a scene: labels of its light."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from ...core.model import Model
from ..description.surroundings import AreaLight, Environment, LampKind, SkyEnvironment
from .colour import luminance
from .environments import bake_environment
from .lamps import lamp_flux, lamp_luminance
from .metering import irradiance

# Lux per kilolux.
_LUX = 1e3


class LampLight(Model):
    """The light of one lamp."""

    kind: LampKind
    luminance: float = Field(description="Of its face [cd/m^2]")
    flux: float = Field(description="Luminous flux that leaves it [lm]")
    illuminance: float = Field(description="By it alone at the table's centre [lx]")


class Photometry(Model):
    """The light of a scene, unshadowed by its objects, as if radiance were in kcd/m^2."""

    illuminance: float = Field(description="At the table's centre, facing up [lx]")
    environment_illuminance: float = Field(description="The part of the surroundings, sun included [lx]")
    sun_illuminance: float | None = Field(
        description="Of a plane that faces the sun, below the clear sky [lx]; null without a sun of known illuminance"
    )
    lamps: tuple[LampLight, ...] = Field(description="In the order of the scene's lights")


def photometry(environment: Environment, lights: tuple[AreaLight, ...]) -> Photometry:
    """Return the light of a scene.

    Parameters
    ----------
    environment : Environment
        The surroundings; their map is baked, or remembered.
    lights : tuple of AreaLight
        The lamps.
    """
    pixels = bake_environment(environment)
    ambient = _LUX * float(luminance(irradiance(pixels, environment.strength, ())))
    lamps = tuple(_lamp(light) for light in lights)
    sun = environment.sun_illuminance if isinstance(environment, SkyEnvironment) else None
    return Photometry(
        illuminance=ambient + sum(lamp.illuminance for lamp in lamps),
        environment_illuminance=ambient,
        sun_illuminance=None if sun is None else _LUX * environment.strength * sun,
        lamps=lamps,
    )


def _lamp(light: AreaLight) -> LampLight:
    dark = np.zeros((2, 4, 3), np.float32)
    return LampLight(
        kind=light.kind,
        luminance=lamp_luminance(light),
        flux=lamp_flux(light),
        illuminance=_LUX * float(luminance(irradiance(dark, 1.0, (light,)))),
    )
