"""How much light falls on the table, and the exposure that follows from it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..description.surroundings import AreaLight
from .colour import luminance
from .sphere import cosine_weights


def irradiance(environment_pixels: np.ndarray, strength: float, lights: Sequence[AreaLight]) -> np.ndarray:
    """Return the irradiance of an unshadowed horizontal patch that faces +z at the table's centre.

    The environment's rotation is about the patch's normal and changes nothing.

    Parameters
    ----------
    environment_pixels : (h, 2 * h, 3) float
        Baked environment (`sphere` has the layout), linear Rec.709 radiance.
    strength : float
        Factor on the environment.
    lights : sequence of AreaLight
        The rectangles; their shadows against the environment are ignored.

    Returns
    -------
    (3,) float64
        Radiance times steradian, linear Rec.709.
    """
    rows = environment_pixels.mean(axis=1, dtype=np.float64) * environment_pixels.shape[1]
    total = strength * (cosine_weights(len(rows)) @ rows)
    for light in lights:
        total = total + np.array(light.radiance) * math.pi * form_factor(light)
    return total


def exposure(irradiance: np.ndarray) -> float:
    """Return the factor from radiance to the linear value that sRGB encodes.

    An incident-light meter: a diffuse surface of reflectance R has the radiance R E / pi, and is encoded as R, so that
    an 18 % grey card on the table comes out at a linear 0.18 whatever the light.

    Parameters
    ----------
    irradiance : (3,) float
        At the table's centre, linear Rec.709; its luminance counts.
    """
    level = float(luminance(irradiance))
    if not level > 0.0:
        raise ValueError(f"irradiance: expected light on the table, got {level}")
    return math.pi / level


def form_factor(light: AreaLight) -> float:
    """Return the form factor from a patch at the origin that faces +z to a rectangle: E = pi L F.

    Lambert's exact formula for a polygon, F = 1 / (2 pi) sum_i theta_i (n . g_i), with the angle theta_i that edge i
    subtends at the patch and the unit normal g_i of the plane through the patch and the edge (Lambert, Photometria,
    1760; see Baum, Rushmeier, Winget, "Improving Radiosity Solutions Through the Use of Analytically
    Determined Form-Factors", SIGGRAPH 1989). The part below the patch's horizon is cut off first.

    Parameters
    ----------
    light : AreaLight
        The rectangle; 0 where it faces away.
    """
    pose = light.world_T_light
    if not pose[:3, 2] @ pose[:3, 3] < 0.0:
        return 0.0
    half = 0.5 * np.array(light.size)
    signs = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    corners = pose[:3, 3] + (signs * half) @ pose[:3, :2].T
    return polygon_form_factor(corners)


def polygon_form_factor(corners: np.ndarray) -> float:
    """Return Lambert's form factor from a patch at the origin that faces +z to a polygon, (n, 3) [m]."""
    corners = _above(corners)
    if len(corners) < 3:
        return 0.0
    following = np.roll(corners, -1, axis=0)
    cross = np.cross(corners, following)
    sine = np.linalg.norm(cross, axis=1)
    angle = np.arctan2(sine, np.sum(corners * following, axis=1))
    tilt = np.divide(cross[:, 2], sine, out=np.zeros_like(sine), where=sine > 0.0)
    return abs(float(angle @ tilt)) / (2.0 * math.pi)


def _above(corners: np.ndarray) -> np.ndarray:
    """Return the part of a polygon with z >= 0 (Sutherland and Hodgman 1974, one plane)."""
    kept: list[np.ndarray] = []
    for here, there in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if here[2] >= 0.0:
            kept.append(here)
        if (here[2] >= 0.0) != (there[2] >= 0.0):
            kept.append(here + (there - here) * (here[2] / (here[2] - there[2])))
    return np.array(kept)
