"""Smooth seeded noise on points in space."""

from __future__ import annotations

import numpy as np

# Odd 32-bit multipliers that spread lattice coordinates over the hash (Teschner et al., "Optimized Spatial Hashing
# for Collision Detection of Deformable Objects", VMV 2003) and Murmur3's 32-bit finaliser.
_SPREAD = np.array([73856093, 19349663, 83492791], dtype=np.uint32)
_MIX = (np.uint32(0x85EBCA6B), np.uint32(0xC2B2AE35))


def value_noise(points: np.ndarray, seed: int) -> np.ndarray:
    """Return value noise: random values on the integer lattice, joined by smooth steps.

    Parameters
    ----------
    points : (..., 3) float
        Where; features are about one unit wide.
    seed : int
        Chooses the lattice values.

    Returns
    -------
    (...) float32
        In [0, 1], mean 1/2.
    """
    base = np.floor(points)
    f = (points - base).astype(np.float32)
    f = f * f * (3.0 - 2.0 * f)
    # The hash goes axis by axis, so the eight corners share its first steps.
    bits, cell = np.full(f.shape[:-1], seed & 0xFFFFFFFF, dtype=np.uint32), base.astype(np.int64)
    return _joined(bits, cell, f, 0)


def fractal_noise(points: np.ndarray, seed: int, octaves: int) -> np.ndarray:
    """Return the sum of octaves of `value_noise`, each half as wide and half as strong; in [0, 1], (...) float32."""
    total = value_noise(points, seed)
    for k in range(1, octaves):
        total += value_noise(points * 2.0**k, seed + k) * np.float32(0.5**k)
    return total / np.float32(2.0 - 0.5 ** (octaves - 1))


def lattice(cell: np.ndarray, seed: int) -> np.ndarray:
    """Return a random value in [0, 1) for each lattice point (..., 3) int, (...) float32."""
    bits = np.full(cell.shape[:-1], seed & 0xFFFFFFFF, dtype=np.uint32)
    for axis in range(3):
        bits = _step(bits, cell[..., axis], axis)
    return _unit(bits)


def _joined(bits: np.ndarray, cell: np.ndarray, f: np.ndarray, axis: int) -> np.ndarray:
    """Return the lattice values interpolated along this axis and those after it."""
    if axis == 3:
        return _unit(bits)
    low = _joined(_step(bits, cell[..., axis], axis), cell, f, axis + 1)
    high = _joined(_step(bits, cell[..., axis] + 1, axis), cell, f, axis + 1)
    return low + (high - low) * f[..., axis]


def _step(bits: np.ndarray, coordinate: np.ndarray, axis: int) -> np.ndarray:
    return _mixed(bits ^ (coordinate.astype(np.uint32) * _SPREAD[axis]))


def _unit(bits: np.ndarray) -> np.ndarray:
    return (bits >> np.uint32(8)).astype(np.float32) * np.float32(2.0**-24)


def _mixed(bits: np.ndarray) -> np.ndarray:
    bits = (bits ^ (bits >> np.uint32(16))) * _MIX[0]
    bits = (bits ^ (bits >> np.uint32(13))) * _MIX[1]
    return bits ^ (bits >> np.uint32(16))
