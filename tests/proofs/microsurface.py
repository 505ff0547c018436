"""Rough interfaces: reciprocity, and the first facet met against Mitsuba's model."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi
import numpy as np
from scipy import stats

from .bundles import rows, scattered
from .check import FALSE_ALARM, Check, single

_N = 1.5
#: Cells that expect fewer events than this are pooled: a normal law holds well enough above (Cochran 1954 asks for 5).
_LEAST = 25
#: Cells of the angle from the normal, of equal projected solid angle, and of the angle between the two azimuths.
_ELEVATIONS, _AZIMUTHS = 8, 6


def reciprocity(rays: int, alphas: tuple[float, ...] = (0.05, 0.2, 0.5), seed: int = 1) -> list[Check]:
    """Send diffuse light at a rough interface from both sides and compare how much goes from where to where.

    Reversed, a path carries the same light: ``f(i, o) = f(o, i)`` for reflection and ``f(i, o) / n_o^2 =
    f(o, i) / n_i^2`` for transmission (Veach 1997, eq. 5.12). Under diffuse light the flux from cell i to cell o is
    then that from o to i, times the ratio of the squared indices where it crosses. Cells are compared by chi-square.

    Parameters
    ----------
    rays : int
        Rays from the thinner side; from the denser side `n^2` times as many, which balances both.
    alphas : tuple of float
        GGX roughness.
    seed : int
        Seed.
    """
    dense = round(rays * _N**2)
    checks = []
    for alpha in alphas:
        up_r, up_t = _flux(rays, _N, alpha, seed)
        down_r, down_t = _flux(dense, 1.0 / _N, alpha, seed + 1)
        scale = rays * _N**2 / dense  # rounding of the count
        what = f"rough {alpha:g}"
        checks.append(_chi2(f"Reciprocity: transmission, {what}", up_t, down_t.swapaxes(0, 1), scale))
        for side, flux in (("air", up_r), ("glass", down_r)):
            # A matrix against its own transpose: each pair of cells once, the diagonal says nothing.
            upper = np.triu_indices(_ELEVATIONS, 1)
            name = f"Reciprocity: reflection in {side}, {what}"
            checks.append(_chi2(name, flux[upper], flux.swapaxes(0, 1)[upper], 1.0))
    return checks


def _flux(rays: int, eta: float, alpha: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Count diffuse rays by cell of arrival, cell of departure and azimuth between: mirrored and let through."""
    rng = np.random.default_rng(seed)
    sin2 = rng.random(rays)
    wi = np.stack([np.sqrt(sin2), np.zeros(rays), np.sqrt(1.0 - sin2)], 1)
    keep = wi[:, 2] > 1e-4  # float32 leaves nothing of the cosine below; a share of 1e-8
    event = scattered(wi[keep], eta, alpha, np.zeros(keep.sum()), seed)
    out = event.direction
    arrival = _cell(sin2[keep], _ELEVATIONS)
    departure = _cell(out[:, 0] ** 2 + out[:, 1] ** 2, _ELEVATIONS)
    between = _cell(np.abs(np.arctan2(out[:, 1], out[:, 0])) / np.pi, _AZIMUTHS)
    counts = np.zeros((2, _ELEVATIONS, _ELEVATIONS, _AZIMUTHS))
    np.add.at(counts, (event.transmitted.astype(int), arrival, departure, between), event.weight > 0.0)
    return counts[0], counts[1]


def _cell(share: np.ndarray, count: int) -> np.ndarray:
    return np.minimum((share * count).astype(int), count - 1)


def _chi2(name: str, one: np.ndarray, other: np.ndarray, scale: float) -> Check:
    """Compare two arrays of counts, of which the second is expected to be the first over `scale`."""
    one, other = one.ravel(), other.ravel() * scale
    many = one + other >= 2 * _LEAST
    if not many.any():
        raise ValueError(f"{name}: expected a cell with {2 * _LEAST} events, found none; more rays are needed")
    a, b = np.append(one[many], one[~many].sum()), np.append(other[many], other[~many].sum())
    a, b = a[a + b > 0], b[a + b > 0]
    statistic = ((a - b) ** 2 / (a + scale * b)).sum()  # the variance of scale * Poisson is scale^2 times its mean
    limit = stats.chi2.isf(FALSE_ALARM, len(a)) / len(a)
    basis = f"chi-square of {len(a)} cells, {a.sum() + b.sum():.0f} events, false alarm {FALSE_ALARM:g}"
    measured = float(statistic / len(a))
    return single(name + ", chi-square a cell", 1.0, measured, measured, "", limit, basis)


def first_facet(rays: int, alpha: float = 0.1, degrees: float = 30.0, seed: int = 1) -> list[Check]:
    """Compare with Mitsuba's `roughdielectric`, which ends at the first facet and loses what would meet another.

    Our light in a cell is Mitsuba's and what came there over more facets. So no cell may hold less than Mitsuba's, and
    all excess together, the summed difference, is what Mitsuba's model loses.

    Parameters
    ----------
    rays : int
        Rays of each of the two.
    alpha : float
        GGX roughness.
    degrees : float
        Angle of incidence [deg].
    seed : int
        Seed.
    """
    theta = np.radians(degrees)
    checks = []
    for side, eta in (("air to glass", _N), ("glass to air", 1.0 / _N)):
        wi = np.array([np.sin(theta), 0.0, np.cos(theta)])
        event = scattered(np.broadcast_to(wi, (rays, 3)), eta, alpha, np.zeros(rays), seed)
        ours, our_variance = _histogram(event.direction, np.where(event.weight > 0.0, 1.0, 0.0))
        direction, weight = _mitsuba(wi, eta, alpha, rays, seed)
        theirs, their_variance = _histogram(direction, weight)
        spread = np.sqrt(our_variance + their_variance)
        used = spread > 0.0
        deficit = np.max((theirs - ours)[used] / spread[used])
        name = f"First facet, rough {alpha:g}, {side}, {degrees:g} deg"
        limit = stats.norm.isf(FALSE_ALARM / used.sum())
        basis = f"normal law in {used.sum()} cells, false alarm {FALSE_ALARM:g}"
        checks.append(single(f"{name}: largest lack in a cell", 0.0, deficit, max(deficit, 0.0), "sigma", limit, basis))
        lost = 1.0 - theirs.sum()
        difference = 100.0 * np.abs(ours - theirs).sum()
        # What noise alone adds to a sum of absolute values, at most, and its own spread.
        noise = spread.sum() * np.sqrt(2.0 / np.pi) + stats.norm.isf(FALSE_ALARM) * np.sqrt((spread**2).sum())
        basis = "light that Mitsuba's model loses, and noise"
        checks.append(
            single(f"{name}: summed difference", 0.0, difference, difference, "%", 100.0 * (lost + noise), basis)
        )
    return checks


def _mitsuba(wi: np.ndarray, eta: float, alpha: float, rays: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return directions and shares of energy of Mitsuba's samples."""
    bsdf = mi.load_dict(
        {"type": "roughdielectric", "distribution": "ggx", "alpha": alpha, "int_ior": eta, "ext_ior": 1.0}
    )
    si = dr.zeros(mi.SurfaceInteraction3f, rays)
    si.wi = mi.Vector3f(*map(float, wi))
    numbers = np.random.default_rng(seed).random((3, rays), dtype=np.float32)
    sample, weight = bsdf.sample(mi.BSDFContext(), si, mi.Float(numbers[0]), mi.Point2f(numbers[1], numbers[2]))
    transmitted = mi.Frame3f.cos_theta(sample.wo) < 0.0
    energy = weight[0] * dr.select(transmitted, eta**2, 1.0)  # radiance there is squeezed, energy is not
    dr.eval(sample, energy)
    return rows(sample.wo), np.array(energy, np.float64)


def _histogram(direction: np.ndarray, weight: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean weight in cells of equal size in the projected disc, both sides, and its variance."""
    cells = 32
    x, y = (_cell(0.5 * (np.clip(direction[:, axis], -1.0, 1.0) + 1.0), cells) for axis in (0, 1))
    cell = (x * cells + y) * 2 + (direction[:, 2] < 0.0)
    count = len(direction)
    first = np.bincount(cell, weight, 2 * cells**2) / count
    second = np.bincount(cell, weight**2, 2 * cells**2) / count
    return first, (second - first**2) / count
