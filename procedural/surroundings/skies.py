"""Procedural skies as environments: drawn, and baked to a map of radiance [kcd/m^2]."""

from __future__ import annotations

import math

import numpy as np

from ..description.surroundings import SkyEnvironment
from ..materials.noise import fractal_value_noise
from .colour import black_body, rgb_of_xyy
from .preetham import sky_xyy, zenith_xyy
from .sphere import cosine_weights, texel_directions

# The sun's disc is even out to this fraction of its radius and fades to 0 at the radius.
_SUN_CORE = 0.5
# Height of the clouds over their typical width.
_CLOUD_HEIGHT = 1.4
# Highest trees round the place [rad], and what leaves reflect (green vegetation: 0.03 to 0.1 in the visible).
_TREES, _LEAVES = 0.45, np.array([0.055, 0.075, 0.03])
# Correlated colour temperature of the sun high and at the horizon [K] (photographers' rule: noon 5500, sunset 2500).
_SUN_HIGH, _SUN_LOW = 5500.0, 2500.0


def draw_sky(rng: np.random.Generator) -> SkyEnvironment:
    """Draw a sky: sun 8 to 65 degrees high, clear to hazy, cloudless to broken.

    The sun is softer than the real one, as behind thin cloud: its illuminance on a plane that faces it is 1 to 5 times
    pi times the zenith's luminance (on a clear day about 8: 100 klx over pi times 4 kcd/m^2). A path tracer finds it
    easily, and glass still throws caustics.
    """
    radius = math.radians(rng.uniform(2.0, 5.0))
    facing = math.exp(rng.uniform(math.log(1.0), math.log(5.0)))
    grey, green = rng.uniform(0.08, 0.3), rng.uniform(0.0, 0.4)
    return SkyEnvironment(
        sun_elevation=math.radians(rng.uniform(8.0, 65.0)),
        sun_radiance=facing * math.pi / disc_solid_angle(radius),
        sun_radius=radius,
        turbidity=float(rng.uniform(2.0, 5.0)),
        cloudiness=float(rng.choice([0.0, rng.uniform(0.1, 0.8)], p=[0.25, 0.75])),
        ground=(grey * (1.0 + 0.2 * green), grey * (1.0 + 0.3 * green), grey * (1.0 - 0.6 * green)),
        seed=int(rng.integers(2**31)),
        rotation=float(rng.uniform(0.0, 2.0 * math.pi)),
    )


def bake_sky(environment: SkyEnvironment, height: int = 512) -> np.ndarray:
    """Return the radiance of a sky, without ``rotation`` and ``strength``.

    Clear sky after Preetham et al. (`preetham`), clouds in front of it, a soft sun at azimuth 0 that they dim, and
    below a skyline the ground, lit by all of it.

    Parameters
    ----------
    environment : SkyEnvironment
        The sky.
    height : int
        Rows of the map.

    Returns
    -------
    (height, 2 * height, 3) float32
        Linear Rec.709 [kcd/m^2], laid out as `sphere` says.
    """
    directions = texel_directions(height)
    sun = sun_direction(environment)
    clear = np.maximum(rgb_of_xyy(sky_xyy(directions, sun, environment.turbidity)), 0.0)
    cover, thickness = _clouds(environment, directions)
    cloud = _cloud_radiance(environment, directions, sun, clear, thickness)
    sky = clear * (1.0 - cover[..., None]) + cloud * cover[..., None]
    # A cloud scatters what it takes from the disc; at most 90 % is taken, so that the sun stays visible.
    sky += _sun(environment, directions, sun) * (1.0 - 0.9 * cover[..., None])
    return _with_ground(environment, directions, sky).astype(np.float32)


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


def _sun(environment: SkyEnvironment, directions: np.ndarray, sun: np.ndarray) -> np.ndarray:
    # The chord is twice the sine of half the angle: exact for small angles, where an arc cosine of float32 is not.
    angle = 2.0 * np.arcsin(np.clip(0.5 * np.linalg.norm(directions - sun, axis=-1), 0.0, 1.0))
    fade = np.clip((angle / environment.sun_radius - _SUN_CORE) / (1.0 - _SUN_CORE), 0.0, 1.0)
    profile = 1.0 - fade * fade * (3.0 - 2.0 * fade)
    colour = _sun_colour(environment)
    level = environment.sun_radiance * zenith_xyy(float(sun[2]), environment.turbidity)[2]
    return profile[..., None] * colour * level


def _sun_colour(environment: SkyEnvironment) -> np.ndarray:
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
    environment: SkyEnvironment, directions: np.ndarray, sun: np.ndarray, clear: np.ndarray, thickness: np.ndarray
) -> np.ndarray:
    """Return the radiance of the clouds: white diffusers lit by sun and sky."""
    zenith = zenith_xyy(float(sun[2]), environment.turbidity)[2]
    facing = environment.sun_radiance * zenith * disc_solid_angle(environment.sun_radius)
    mean = (cosine_weights(len(clear)) @ clear.sum(axis=1)) / math.pi
    lit = mean + _sun_colour(environment) * facing * max(float(sun[2]), 0.2) / math.pi
    toward = np.clip(directions @ sun, 0.0, 1.0)
    # Droplets scatter forward: the silver lining within some 20 degrees of the sun.
    lining = 1.0 + 1.5 * toward**16 * (1.0 - thickness)
    shade = (1.0 - 0.35 * thickness**2) * lining
    return lit * shade[..., None]


def _with_ground(environment: SkyEnvironment, directions: np.ndarray, sky: np.ndarray) -> np.ndarray:
    """Return the map with land below the skyline: open ground near by, and a belt of trees round it."""
    upward = np.where(directions[..., 2:] > 0.0, sky, 0.0)
    # A white diffuser on the ground has this radiance.
    white = (cosine_weights(len(sky)) @ upward.sum(axis=1)) / math.pi
    flat = directions * np.array([1.0, 1.0, 0.0], dtype=np.float32)
    flat /= np.linalg.norm(flat, axis=-1, keepdims=True)
    seed, elevation = environment.seed, np.arcsin(directions[..., 2])
    # Noise is worked out in the rows where it shows: trees from their feet to the highest top, ground below them.
    texel = math.pi / len(sky)
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
    feet = np.clip((elevation + 0.03 * crowns) * len(sky) / math.pi + 0.5, 0.0, 1.0)[..., None]
    tops = np.clip((elevation - skyline) * len(sky) / math.pi + 0.5, 0.0, 1.0)[..., None]
    return tops * sky + (1.0 - tops) * (feet * trees + (1.0 - feet) * ground)


def _noise_in(rows: np.ndarray, points: np.ndarray, seed: int, octaves: int) -> np.ndarray:
    """Return `fractal_value_noise` in some rows of a map and 0 elsewhere; (h,) bool, (h, w, 3) -> (h, w) float32."""
    out = np.zeros(points.shape[:-1], np.float32)
    out[rows] = fractal_value_noise(points[rows], seed, octaves)
    return out
