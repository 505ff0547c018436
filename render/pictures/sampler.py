"""Sampler: Owen-scrambled Sobol' points of four dimensions, padded to any number, one scramble a pixel.

Burley 2020, "Practical Hash-based Owen Scrambling" (JCGT 9(4)): a set of four dimensions is scrambled by a hash, and
its order is shuffled by another. Each set is a low-discrepancy point set, and different sets are independent.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from .._mitsuba import dr, mi

#: Degree, coefficients and first direction numbers of the primitive polynomials for dimensions 2 to 4
#: (Joe and Kuo 2008, "Constructing Sobol Sequences with Better Two-Dimensional Projections", table new-joe-kuo-6).
_POLYNOMIALS = ((1, 0, (1,)), (2, 1, (1, 3)), (3, 1, (1, 3, 1)))
_DIMENSIONS, _BITS = 4, 32
#: Points in the table [1]; longer sequences continue with new scrambles.
_POINTS = 1 << 14


@dataclass(frozen=True, eq=False)
class SobolSampler:
    """The sampler of a wavefront: a path is sample `index` of pixel `pixel`."""

    pixel: mi.UInt32
    index: mi.UInt32
    seed: mi.UInt32
    mask: mi.UInt32  #: number of points in use minus one, a power of two minus one
    table: mi.UInt32  #: coordinates of the Sobol' points as 32-bit fractions, four a point


def sobol_sampler(pixel: mi.UInt32, index: mi.UInt32, count: int, seed: int) -> SobolSampler:
    """Return the sampler of a wavefront of paths.

    Parameters
    ----------
    pixel, index : mi.UInt32
        Pixel of each path, and which of the pixel's samples it is.
    count : int
        Samples of each pixel in all passes. Powers of two have the lowest discrepancy.
    seed : int
        32-bit seed of the picture.
    """
    points = min(_POINTS, 1 << max(0, count - 1).bit_length())
    return SobolSampler(pixel, index, dr.opaque(mi.UInt32, seed), dr.opaque(mi.UInt32, points - 1), _table())


def sample_4d(sampler: SobolSampler, number: mi.UInt32) -> tuple[mi.Float, mi.Float, mi.Float, mi.Float]:
    """Return the four dimensions of set `number`, each in [0, 1)."""
    index, scramble = _shuffled(sampler, number)
    a, b, c, d = (_coordinate(sampler, index, scramble, mi.UInt32(axis)) for axis in range(_DIMENSIONS))
    return a, b, c, d


def sample_1d(sampler: SobolSampler, number: mi.UInt32, axis: mi.UInt32) -> mi.Float:
    """Return one dimension of set `number`; `axis` may differ by lane."""
    index, scramble = _shuffled(sampler, number)
    return _coordinate(sampler, index, scramble, axis)


def hashed_seed(sampler: SobolSampler, number: mi.UInt32) -> mi.UInt32:
    """Return a seed that differs by path and by `number`, for random walks of unknown length."""
    seed, _ = mi.sample_tea_32(
        sampler.pixel ^ (sampler.index * 0x9E3779B9), sampler.seed ^ (number * 0xC2B2AE35 + 1), 4
    )
    return seed


def _shuffled(sampler: SobolSampler, number: mi.UInt32) -> tuple[mi.UInt32, mi.UInt32]:
    """Return the index of a sample's point in the shuffled set, and the seed of the set's scramble."""
    # The number of the pass through the table is part of the hash: samples beyond the table get new scrambles.
    lap = sampler.index & ~sampler.mask
    order, scramble = mi.sample_tea_32(sampler.pixel ^ (lap * 0x9E3779B9), sampler.seed + number * 0x85EBCA6B, 4)
    return _scrambled(sampler.index, order) & sampler.mask, scramble


def _coordinate(sampler: SobolSampler, index: mi.UInt32, scramble: mi.UInt32, axis: mi.UInt32) -> mi.Float:
    raw = dr.gather(mi.UInt32, sampler.table, index * _DIMENSIONS + axis)
    bits = _scrambled(raw, _mixed(scramble + axis * 0x9E3779B9))
    return mi.Float(bits >> 8) * 2.0**-24


def _mixed(x: mi.UInt32) -> mi.UInt32:
    """Return a hash of all bits in each bit (Wellons, "Hash Prospector", lowbias32).

    A scramble flips a coordinate's leading bit by the seed's last bit alone. If the seeds of two axes differed by a
    constant, both axes would flip together in every pixel, and parts of the square would never be sampled.
    """
    x = (x ^ (x >> 16)) * 0x7FEB352D
    x = (x ^ (x >> 15)) * 0x846CA68B
    return x ^ (x >> 16)


def _scrambled(x: mi.UInt32, seed: mi.UInt32) -> mi.UInt32:
    """Flip each bit by a hash of the bits above it (Laine and Karras 2011; constants of Burley 2020, listing 3)."""
    x = dr.brev(x) + seed
    for factor in (0x6C50B47C, 0xB82F1E52, 0xC7AFE638, 0x8D22F6E6):
        x ^= x * factor
    return dr.brev(x)


@cache
def _directions() -> np.ndarray:
    """Direction numbers of the four dimensions, (4, 32) uint64 (Joe and Kuo 2008, eq. 2 and 3)."""
    columns = [[1 << (_BITS - 1 - k) for k in range(_BITS)]]
    for degree, coefficients, first in _POLYNOMIALS:
        m = list(first)
        for k in range(degree, _BITS):
            value = m[k - degree] ^ (m[k - degree] << degree)
            for j in range(1, degree):
                value ^= ((coefficients >> (degree - 1 - j)) & 1) * (m[k - j] << j)
            m.append(value)
        columns.append([m[k] << (_BITS - 1 - k) for k in range(_BITS)])
    return np.array(columns, np.uint64)


def sobol(count: int) -> np.ndarray:
    """Return the first points of the Sobol' sequence, (count, 4) uint32 as 32-bit fractions."""
    index = np.arange(count, dtype=np.uint64)
    points = np.zeros((count, _DIMENSIONS), np.uint64)
    for bit in range(max(1, int(count - 1).bit_length())):
        chosen = (index >> np.uint64(bit)) & np.uint64(1)
        points ^= chosen[:, None] * _directions()[None, :, bit]
    return points.astype(np.uint32)


def _table() -> mi.UInt32:
    table = mi.UInt32(sobol(_POINTS).ravel())
    dr.make_opaque(table)
    return table
