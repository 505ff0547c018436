"""Procedural skies as environments: drawn, and baked to a map of radiance [kcd/m^2]."""

from __future__ import annotations

import math

import numpy as np

from ..description.surroundings import SkyEnvironment
from ..materials.noise import fractal_value_noise
from .colour import black_body, luminance, rgb_of_xyy
from .preetham import sky_xyy, zenith_xyy
from .sphere import cosine_weights, doubled, softened, solid_angles, texel_directions
from .sun import SUN_RADIUS, clear_daylight, disc_coverage, disc_luminance

# A soft sun's disc is even out to this fraction of its radius and fades to 0 at the radius.
_SUN_CORE = 0.5
# Optical depth of a whole cloud in front of the sun (fair-weather cumulus: 3.6 to 23 in the middle, less at the edges;
# ISCCP classes, Rossow and Schiffer 1999), and what a cloud sends down of the light on it, before it grows thick: about
# 1 / (1 + 3/4 (1 - g) depth) for droplets that scatter forward, g = 0.85 (two-stream approximation, Bohren 1987).
_CLOUD_DEPTH, _CLOUD_BASE = 10.0, 0.47
# Height of the clouds over their typical width.
_CLOUD_HEIGHT = 1.4
# Highest trees round the place [rad], and what leaves reflect (green vegetation: 0.03 to 0.1 in the visible).
_TREES, _LEAVES = 0.45, np.array([0.055, 0.075, 0.03])
# Colour temperature of the soft sun high and at the horizon [K] (photographers' rule: noon 5500, sunset 2500).
_SUN_HIGH, _SUN_LOW = 5500.0, 2500.0


def draw_sky(rng: np.random.Generator, sun_radius: float = SUN_RADIUS) -> SkyEnvironment:
    """Draw a sky: sun 8 to 65 degrees high, clear to hazy, cloudless to broken.

    The sun's illuminance is that of a clear sky (`sun.clear_daylight`); clouds dim it when the sky is baked.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of all draws.
    sun_radius : float
        Angular radius of the sun [rad].
    """
    elevation, turbidity = math.radians(rng.uniform(8.0, 65.0)), float(rng.uniform(2.0, 5.0))
    grey, green = rng.uniform(0.08, 0.3), rng.uniform(0.0, 0.4)
    return SkyEnvironment(
        sun_elevation=elevation,
        sun_illuminance=clear_daylight(elevation, turbidity).beam,
        sun_radius=sun_radius,
        turbidity=turbidity,
        cloudiness=float(rng.choice([0.0, rng.uniform(0.1, 0.8)], p=[0.25, 0.75])),
        ground=(grey * (1.0 + 0.2 * green), grey * (1.0 + 0.3 * green), grey * (1.0 - 0.6 * green)),
        seed=int(rng.integers(2**31)),
        rotation=float(rng.uniform(0.0, 2.0 * math.pi)),
    )


def bake_sky(environment: SkyEnvironment, height: int = 512) -> np.ndarray:
    """Return the radiance of a sky, without ``rotation`` and ``strength``.

    Clear sky after Preetham et al. (`preetham`), clouds in front of it, the sun at azimuth 0 that they dim, and below a
    skyline the ground, lit by all of it. The clear sky's light on the ground is that of `sun.clear_daylight`.

    Parameters
    ----------
    environment : SkyEnvironment
        The sky.
    height : int
        Rows at which sky and ground are worked out and softened. A sharp sun needs finer texels: it is added to a map
        of twice the rows, where it is 3 texels of 0.18 degrees wide.

    Returns
    -------
    (2 * height, 4 * height, 3) float32
        Linear Rec.709 [kcd/m^2], laid out as `sphere` says; (height, 2 * height, 3) with a soft sun, which descriptions
        without ``sun_illuminance`` have.
    """
    directions, sun = texel_directions(height), sun_direction(environment)
    clear = np.maximum(rgb_of_xyy(sky_xyy(directions, sun, environment.turbidity)), 0.0)
    if environment.sun_illuminance is None:
        return _with_soft_sun(environment, directions, clear)
    daylight = clear_daylight(environment.sun_elevation, environment.turbidity)
    clear *= daylight.diffuse / float(luminance(_horizontal(clear)))
    beam = daylight.colour * environment.sun_illuminance
    cover, thickness = _clouds(environment, directions)
    cloud = _CLOUD_BASE * _cloud_radiance(environment, directions, clear, thickness, beam)
    sky = clear * (1.0 - cover[..., None]) + cloud * cover[..., None]
    disc = disc_coverage(2 * height, environment.sun_elevation, environment.sun_radius)
    passed = np.exp(-_CLOUD_DEPTH * doubled(cover)) * disc
    weights = solid_angles(2 * height)
    fraction = float(weights @ passed.sum(axis=1, dtype=np.float64)) / float(
        weights @ disc.sum(axis=1, dtype=np.float64)
    )
    land, open_sky = _ground(environment, directions, _horizontal(sky) + beam * fraction * float(sun[2]))
    smooth = doubled(softened((open_sky * sky + land).astype(np.float32)))
    level = disc_luminance(1.0, environment.sun_radius) * passed * doubled(open_sky[..., 0].astype(np.float32))
    return smooth + level[..., None] * beam.astype(np.float32)


def _with_soft_sun(environment: SkyEnvironment, directions: np.ndarray, clear: np.ndarray) -> np.ndarray:
    """Return the map of a description whose sun is a soft disc, of a luminance relative to the zenith's."""
    sun = sun_direction(environment)
    cover, thickness = _clouds(environment, directions)
    zenith = zenith_xyy(float(sun[2]), environment.turbidity)[2]
    facing = environment.sun_radiance * zenith * disc_solid_angle(environment.sun_radius)
    cloud = _cloud_radiance(environment, directions, clear, thickness, _soft_sun_colour(environment) * facing)
    sky = clear * (1.0 - cover[..., None]) + cloud * cover[..., None]
    # A cloud scatters what it takes from the disc; at most 90 % is taken, so that the sun stays visible.
    sky += _soft_sun(environment, directions, sun) * (1.0 - 0.9 * cover[..., None])
    land, open_sky = _ground(environment, directions, _horizontal(sky))
    return softened((open_sky * sky + land).astype(np.float32))


def sun_direction(environment: SkyEnvironment) -> np.ndarray:
    """Return the unit vector to the sun before the environment's rotation, (3,) float64."""
    return np.array([math.cos(environment.sun_elevation), 0.0, math.sin(environment.sun_elevation)])


def disc_solid_angle(radius: float) -> float:
    """Return the solid angle of the soft disc, each part weighted by its radiance over the middle's [sr].

    The profile is 1 to the core's edge c = radius / 2 and falls as a smooth step to 0 at the radius; with the small
    angle's flat disc its integral is pi r^2 (c^2 + c (1 - c) + 3/10 (1 - c)^2) with c in units of r.
    """
    c = _SUN_CORE
    return math.pi * radius**2 * (c * c + c * (1.0 - c) + 0.3 * (1.0 - c) ** 2)


def _soft_sun(environment: SkyEnvironment, directions: np.ndarray, sun: np.ndarray) -> np.ndarray:
    # The chord is twice the sine of half the angle: exact for small angles, where an arc cosine of float32 is not.
    angle = 2.0 * np.arcsin(np.clip(0.5 * np.linalg.norm(directions - sun, axis=-1), 0.0, 1.0))
    fade = np.clip((angle / environment.sun_radius - _SUN_CORE) / (1.0 - _SUN_CORE), 0.0, 1.0)
    profile = 1.0 - fade * fade * (3.0 - 2.0 * fade)
    colour = _soft_sun_colour(environment)
    level = environment.sun_radiance * zenith_xyy(float(sun[2]), environment.turbidity)[2]
    return profile[..., None] * colour * level


def _soft_sun_colour(environment: SkyEnvironment) -> np.ndarray:
    height = math.sin(environment.sun_elevation)
    # The path through the air goes as 1 / sine of the elevation; the colour nears the high sun's within some degrees.
    return black_body(_SUN_LOW + (_SUN_HIGH - _SUN_LOW) * (1.0 - math.exp(-height / 0.25)))


def _clouds(environment: SkyEnvironment, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return cover (0 none, 1 full) and thickness (0 to 1) of the clouds, each (h, w)."""
    cover, thickness = (np.zeros(directions.shape[:-1], np.float32) for _ in range(2))
    if environment.cloudiness == 0.0:
        return cover, thickness
    above = directions[:, 0, 2] > 0.0
    cover[above], thickness[above] = _clouds_above(environment, directions[above])
    return cover, thickness


def _clouds_above(environment: SkyEnvironment, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    up = np.maximum(directions[..., 2], 0.03)
    plane = directions[..., :2] / up[..., None] * _CLOUD_HEIGHT
    points = np.concatenate([plane, np.zeros_like(plane[..., :1])], axis=-1)
    # Bent by a slower noise, the cells of the lattice no longer show.
    bend = np.stack([fractal_value_noise(points * 0.7, environment.seed + k, 3) for k in (31, 37)], axis=-1)
    points[..., :2] += 1.6 * (bend - 0.5)
    density = fractal_value_noise(points, environment.seed, 6)
    weights = np.sqrt(1.0 - directions[..., 2] ** 2)
    threshold = _weighted_quantile(density.ravel(), weights.ravel(), 1.0 - environment.cloudiness)
    thickness = np.clip((density - threshold) / 0.25, 0.0, 1.0)
    # Haze swallows clouds within some degrees of the horizon.
    haze = np.clip(directions[..., 2] / 0.35, 0.0, 1.0)
    edge = np.clip((density - threshold) / 0.14 + 0.5, 0.0, 1.0)
    return edge * edge * (3.0 - 2.0 * edge) * haze, thickness


def _weighted_quantile(values: np.ndarray, weights: np.ndarray, fraction: float) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order], dtype=np.float64)
    return float(values[order][np.searchsorted(total, fraction * total[-1])])


def _cloud_radiance(
    environment: SkyEnvironment, directions: np.ndarray, clear: np.ndarray, thickness: np.ndarray, beam: np.ndarray
) -> np.ndarray:
    """Return the radiance of the clouds: white diffusers lit by the sky and the sun's beam, (3,) on a facing plane."""
    sun = sun_direction(environment)
    mean = (cosine_weights(len(clear)) @ clear.sum(axis=1)) / math.pi
    lit = mean + beam * max(float(sun[2]), 0.2) / math.pi
    toward = np.clip(directions @ sun, 0.0, 1.0)
    # Droplets scatter forward: the silver lining within some 20 degrees of the sun.
    lining = 1.0 + 1.5 * toward**16 * (1.0 - thickness)
    shade = (1.0 - 0.35 * thickness**2) * lining
    return lit * shade[..., None]


def _horizontal(sky: np.ndarray) -> np.ndarray:
    """Return the irradiance of level ground by the upper half of a map, (3,)."""
    return cosine_weights(len(sky)) @ sky.sum(axis=1)


def _ground(
    environment: SkyEnvironment, directions: np.ndarray, irradiance: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the land below the skyline: open ground near by, and a belt of trees round it.

    Parameters
    ----------
    environment : SkyEnvironment
        The sky.
    directions : (h, 2 * h, 3) float32
        Of the map's texels.
    irradiance : (3,) float
        Of level ground.

    Returns
    -------
    land : (h, 2 * h, 3) float
        Radiance, 0 where the sky is.
    open_sky : (h, 2 * h, 1) float
        The share of a texel that is sky.
    """
    # A white diffuser on the ground has this radiance.
    white = irradiance / math.pi
    flat = directions * np.array([1.0, 1.0, 0.0], dtype=np.float32)
    flat /= np.linalg.norm(flat, axis=-1, keepdims=True)
    seed, elevation = environment.seed, np.arcsin(directions[..., 2])
    # Noise is worked out in the rows where it shows: trees from their feet to the highest top, ground below them.
    texel = math.pi / len(directions)
    belt = (elevation[:, 0] > -0.03 - texel) & (elevation[:, 0] < 1.6 * _TREES + texel)
    crowns = _noise_in(belt, flat * 12.0, seed + 53, 5)
    skyline = _TREES * _noise_in(belt, flat * 2.0, seed + 51, 2) ** 2 * (0.4 + 1.2 * crowns)
    # Patches of a metre at an eye height of 1.7 m; they fade into the distance.
    depth = np.maximum(-directions[..., 2:], 0.02)
    patches = _noise_in(elevation[:, 0] < texel, directions / depth * 6.0, seed + 59, 5) - 0.5
    near = np.clip(depth[..., 0] / 0.3, 0.0, 1.0)
    ground = white * np.array(environment.ground) * (1.0 + 0.8 * patches * near)[..., None]
    leaves = _noise_in(belt, directions * 30.0, seed + 61, 4) ** 2 * 3.0 * np.clip(0.5 + elevation / 0.2, 0.3, 1.0)
    trees = white * _LEAVES * leaves[..., None]
    # The trees' feet and tops are one texel soft.
    feet = np.clip((elevation + 0.03 * crowns) / texel + 0.5, 0.0, 1.0)[..., None]
    tops = np.clip((elevation - skyline) / texel + 0.5, 0.0, 1.0)[..., None]
    return (1.0 - tops) * (feet * trees + (1.0 - feet) * ground), tops


def _noise_in(rows: np.ndarray, points: np.ndarray, seed: int, octaves: int) -> np.ndarray:
    """Return `fractal_value_noise` in some rows of a map and 0 elsewhere; (h,) bool, (h, w, 3) -> (h, w) float32."""
    out = np.zeros(points.shape[:-1], np.float32)
    out[rows] = fractal_value_noise(points[rows], seed, octaves)
    return out
