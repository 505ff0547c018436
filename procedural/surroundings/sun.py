"""Sun and clear sky in photometric units: illuminance by elevation and haze, and the sun's disc on a map.

The beam is the black body of the sun, seen through air: scattered by molecules and particles and absorbed by ozone
(Preetham, Shirley, Smits, "A Practical Analytic Model for Daylight", SIGGRAPH 1999, appendix A.1). What is scattered
downwards is the light of the clear sky. Beam and sky together are never more than falls on the atmosphere.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .colour import RGB_FROM_XYZ, SECOND_RADIATION, luminance, observer
from .sphere import solid_angles

#: Illuminance of a plane that faces the sun above the atmosphere, at the mean distance [klx] (CIE 108-1994).
SOLAR_ILLUMINANCE = 133.8
#: Angular radius of the sun at the mean distance [rad], 0.2665 degrees: nominal solar radius over the astronomical
#: unit (IAU 2015 resolution B3, IAU 2012 resolution B2).
SUN_RADIUS = math.asin(6.957e8 / 1.495978707e11)
#: Smallest sun that can be asked for [rad]: the real one, rounded down.
SMALLEST_SUN = 4.65e-3
#: Largest sun that can be asked for [rad]: 20 of its radii, as behind thin cloud.
LARGEST_SUN = math.radians(5.0)
# Effective temperature of the sun [K] (IAU 2015 resolution B3).
_SUN_TEMPERATURE = 5772.0
# Preetham et al., appendix A.1: optical depth of molecules and of particles at 1 um and air mass 1, and their powers of
# the wavelength; the particles' depth by the turbidity (slope, constant); vertical thickness of the ozone [cm].
_MOLECULES, _MOLECULE_POWER, _PARTICLE_POWER = 0.008735, -4.08, -1.3
_PARTICLES, _OZONE_THICKNESS = (0.04608, -0.04586), 0.35
# Absorption of ozone [1/cm] by wavelength [nm] (Preetham et al., table 2).
_OZONE_WAVELENGTHS = np.arange(440.0, 741.0, 20.0)
_OZONE = (0.002, 0.006, 0.014, 0.03, 0.048, 0.07, 0.095, 0.118, 0.125, 0.105, 0.079, 0.048, 0.023, 0.011, 0.004, 0.0)
# Of what is scattered, the fraction that goes down: half of it by molecules, 0.84 by particles (Bird and Hulstrom, "A
# Simplified Clear Sky Model for Direct and Diffuse Insolation on Horizontal Surfaces", SERI/TR-642-761, 1981).
_DOWN_MOLECULES, _DOWN_PARTICLES = 0.5, 0.84
# Places per texel and direction where the disc's fraction of a texel is counted.
_DISC_SAMPLES = 16


@dataclass(frozen=True, eq=False)
class Daylight:
    """The light of a clear sky."""

    beam: float  #: illuminance of a plane that faces the sun, without the sky's [klx]
    colour: np.ndarray  #: (3,) float64, linear Rec.709 of the beam, at luminance 1
    diffuse: float  #: illuminance of a horizontal plane by the sky alone [klx]


def air_mass(elevation: float) -> float:
    """Return the length of the sun's path through the air over that of the zenith, at an elevation [rad].

    Kasten and Young, "Revised optical air mass tables and approximation formula", Applied Optics 28(22), 1989.
    """
    degrees = math.degrees(elevation)
    return 1.0 / (math.sin(elevation) + 0.50572 * (degrees + 6.07995) ** -1.6364)


def clear_daylight(elevation: float, turbidity: float) -> Daylight:
    """Return the light of a clear sky.

    Parameters
    ----------
    elevation : float
        Of the sun [rad], above 0.
    turbidity : float
        Haze, 1.7 to 10 (Preetham et al.).
    """
    wavelength = np.arange(380.0, 781.0, 5.0)
    micrometres, mass = 1e-3 * wavelength, air_mass(elevation)
    molecules = _MOLECULES * micrometres**_MOLECULE_POWER
    particles = (_PARTICLES[0] * turbidity + _PARTICLES[1]) * micrometres**_PARTICLE_POWER
    ozone = np.exp(-mass * _OZONE_THICKNESS * np.interp(wavelength, _OZONE_WAVELENGTHS, _OZONE))
    passed = np.exp(-mass * (molecules + particles))
    down = (_DOWN_MOLECULES * molecules + _DOWN_PARTICLES * particles) / (molecules + particles)
    source = wavelength**-5.0 / np.expm1(SECOND_RADIATION / (wavelength * _SUN_TEMPERATURE))
    xyz = source[:, None] * observer(wavelength)
    level = SOLAR_ILLUMINANCE / xyz[:, 1].sum()
    beam, diffuse = level * (ozone * passed) @ xyz, level * (ozone * (1.0 - passed) * down) @ xyz
    # A sun near the horizon is redder than any mixture of the three primaries.
    colour = np.maximum(RGB_FROM_XYZ @ beam, 0.0)
    return Daylight(float(beam[1]), colour / luminance(colour), float(diffuse[1] * math.sin(elevation)))


def disc_luminance(illuminance: float, radius: float) -> float:
    """Return the luminance of an even disc that gives a plane facing it an illuminance: E / (pi sin^2 r).

    Parameters
    ----------
    illuminance : float
        In any unit; the luminance is in that unit per steradian.
    radius : float
        Angular radius [rad].
    """
    return illuminance / (math.pi * math.sin(radius) ** 2)


def disc_coverage(height: int, elevation: float, radius: float) -> np.ndarray:
    """Return the fraction of each texel that a disc at azimuth 0 covers.

    Counted at 16 x 16 places a texel, then scaled so that all shares together are the disc's solid angle.

    Parameters
    ----------
    height : int
        Rows of the map.
    elevation, radius : float
        Of the disc [rad].

    Returns
    -------
    (height, 2 * height) float32
        0 to 1, but for the scaling.
    """
    texel, polar = math.pi / height, 0.5 * math.pi - elevation
    rows = np.arange(max(0, math.floor((polar - radius) / texel)), min(height, math.ceil((polar + radius) / texel)))
    # At the widest, a small circle reaches over asin(sin r / cos h) of azimuth; near the zenith round all of it.
    ratio = math.sin(radius) / max(math.cos(elevation), 1e-12)
    half = height if ratio >= 1.0 else min(height, math.ceil(math.asin(ratio) / texel))
    columns = np.arange(-half, half)
    fraction = np.zeros((len(rows), len(columns)))
    places = (np.arange(_DISC_SAMPLES) + 0.5) / _DISC_SAMPLES
    for u in places:
        theta = (rows[:, None] + u) * texel
        for v in places:
            half_phi, half_theta = 0.5 * (columns + v) * texel, 0.5 * (theta - polar)
            # The haversine of the angle to the middle keeps its digits where a cosine does not.
            haversine = np.sin(half_theta) ** 2 + np.sin(theta) * math.sin(polar) * np.sin(half_phi) ** 2
            fraction += haversine < math.sin(0.5 * radius) ** 2
    weights = solid_angles(height)[rows][:, None]
    fraction *= 2.0 * math.pi * (1.0 - math.cos(radius)) / (fraction * weights).sum()
    coverage = np.zeros((height, 2 * height), np.float32)
    coverage[np.ix_(rows, columns % (2 * height))] = fraction
    return coverage
