"""Forks, knives and spoons: stamped from sheet, bent, with edges that are rounded."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np

from ..patterns.draw import metal
from .kitchen import FORK, KNIFE, SPOON, TEA_SPOON
from .parts import Part, Thing
from .solids import projected, sheet

#: Thickness of the sheet of a fork or a spoon [m]: 1.5-3 mm; it is thickest at the neck.
SHEET = (0.0016, 0.0024)
#: Steps along a piece of cutlery [1].
STEPS = 90


def fork(rng: np.random.Generator, wear: float) -> Thing:
    """Return a table fork with four tines, sometimes three."""
    length, thick = rng.uniform(*FORK), rng.uniform(*SHEET)
    tines = 4 if rng.random() < 0.8 else 3
    width, head = length * rng.uniform(0.125, 0.14), length * rng.uniform(0.34, 0.38)
    slot = 0.48 * head  # tines from here on
    handle = _handle_width(rng, length)
    s = _stations(0.0, length, STEPS)
    half = np.where(s < length - head, handle(s), 0.0)
    # Neck, shoulders, tines that run together a little.
    t = np.clip((s - (length - head)) / (head - slot), 0.0, 1.0)
    neck = handle(np.array([length - head]))[0]
    half = np.where(s >= length - head, neck + (width / 2 - neck) * t * t * (3 - 2 * t), half)
    half = np.where(s > length - slot, width / 2 * (1 - 0.06 * (s - length + slot) / slot), half)
    middle = _bow(s, length, head, dip=0.010, tip=rng.uniform(0.012, 0.018))
    # Columns at the edges of the tines, a gap as wide as a tine is.
    cells = 2 * tines - 1
    edges = np.linspace(-1.0, 1.0, cells + 1)
    across = np.concatenate([np.linspace(a, b, 3)[:-1] for a, b in itertools.pairwise(edges)] + [[1.0]])
    present = np.ones((STEPS - 1, len(across) - 1), bool)
    for gap in range(1, cells, 2):
        present[s[:-1] >= length - slot, 2 * gap : 2 * gap + 2] = False
    # Between the tines the bottoms of the gaps are round, and each tine gets narrow towards its point.
    place = np.repeat(across[None], STEPS, axis=0)
    narrow = np.clip((s - (length - slot)) / slot, 0.0, 1.0)[:, None] ** 2
    centre = np.round((across + 1) * cells / 4 - 0.25) * 4 / cells - 1 + 1 / cells
    place = np.where(s[:, None] > length - slot, place + (centre[None] - place) * 0.6 * narrow, place)
    thickness = np.where(s > length - 0.012, thick * (0.45 + 0.55 * (length - s) / 0.012), thick)
    return _stamped(rng, wear, s, place * half[:, None], middle, thickness, present, trough=0.0008)


def spoon(rng: np.random.Generator, wear: float) -> Thing:
    """Return a table spoon or a tea spoon."""
    length, thick = rng.uniform(*(SPOON if rng.random() < 0.6 else TEA_SPOON)), rng.uniform(*SHEET)
    bowl, width = length * rng.uniform(0.30, 0.34), length * rng.uniform(0.195, 0.215)
    handle = _handle_width(rng, length)
    s = np.concatenate([_stations(0.0, length - bowl, 45)[:-1], _stations(length - bowl, length, 46)])
    t = np.clip((s - (length - bowl)) / bowl, 0.0, 1.0)
    egg = np.sqrt(np.clip(1.0 - (2.0 * t**0.85 - 1.0) ** 2, 0.0, 1.0))
    neck = handle(np.array([length - bowl]))[0]
    half = np.where(s < length - bowl, handle(s), np.maximum(neck * np.clip(1 - 3 * t, 0, 1), width / 2 * egg))
    half = np.maximum(half, 0.0008)
    middle = _bow(s, length, bowl, dip=0.012, tip=0.008)
    across = np.sin(np.linspace(-np.pi / 2, np.pi / 2, 25))
    y = across[None] * half[:, None]
    hollow = width * 0.19 * (4 * t * (1 - t)) ** 0.8
    z = middle[:, None] - hollow[:, None] * (1.0 - across[None] ** 2)
    return _stamped(rng, wear, s, y, z, np.full(len(s), thick * 0.85), None, trough=0.0)


def knife(rng: np.random.Generator, wear: float) -> Thing:
    """Return a table knife, lying: a solid handle and a blade that is thin at its edge."""
    length, blade = rng.uniform(*KNIFE), rng.uniform(0.46, 0.52)
    handle, high = rng.uniform(0.0075, 0.0095), rng.uniform(0.0085, 0.0105)
    s = _stations(0.0, length, STEPS)
    t = np.clip((s / length - (1 - blade)) / blade, 0.0, 1.0)
    ends = np.sqrt(np.clip(1 - (1 - np.clip(s / 0.010, 0, 1)) ** 2, 0.0, 1.0))
    body = (
        handle * (0.86 + 0.14 * np.cos(2 * np.pi * np.clip(s / (length * (1 - blade)), 0, 1))) * np.maximum(ends, 0.15)
    )
    tip = np.clip((1 - t) / 0.22, 0.0, 1.0)
    upper = np.where(t > 0, high * np.sqrt(1 - (1 - tip) ** 2) * np.clip(0.75 + 3 * t, 0, 1), body)
    lower = np.where(t > 0, high * np.clip(0.75 + 6 * t, 0, 1) * (0.35 + 0.65 * np.sqrt(1 - (1 - tip) ** 4)), body)
    upper, lower = np.maximum(upper, 0.0006), np.maximum(lower, 0.0006)
    across = np.sin(np.linspace(-np.pi / 2, np.pi / 2, 15))
    y = np.where(across[None] > 0, across[None] * upper[:, None], across[None] * lower[:, None])
    thick = np.where(t > 0, 0.0016 + 0.004 * np.clip(1 - 12 * t, 0, 1), 0.0068 * np.maximum(ends, 0.2))
    # The blade is ground towards its edge, the handle is round.
    grind = np.where(t[:, None] > 0.03, 0.30 + 0.70 * np.clip((across[None] + 1) / 1.2, 0, 1), 1.0)
    round_ = np.where(t[:, None] > 0.03, 1.0, 0.30 + 0.70 * np.sqrt(1 - 0.98 * across[None] ** 2))
    half = 0.5 * thick[:, None] * grind * round_
    x = np.repeat(s[:, None], len(across), axis=1)
    middle = np.full_like(x, 0.0035)
    mesh = projected(sheet(np.stack([x, y, middle + half], 2), np.stack([x, y, middle - half], 2)))
    return Thing((Part("knife", mesh, metal(rng, wear, "steel", 0.15)),))


def _stations(first: float, last: float, count: int) -> np.ndarray:
    """Return places along a piece of cutlery [m], closest at both ends, which are round."""
    t = np.linspace(0.0, 1.0, count)
    return first + (last - first) * (0.25 * t + 0.375 * (1.0 - np.cos(np.pi * t)))


def _handle_width(rng: np.random.Generator, length: float) -> Callable[[np.ndarray], np.ndarray]:
    """Return half of a handle's width along it: broad and round at the end, narrow at the neck."""
    end, neck = rng.uniform(0.0075, 0.0105), rng.uniform(0.0026, 0.0034)
    waist = rng.uniform(0.55, 0.66) * length

    def half(s: np.ndarray) -> np.ndarray:
        t = np.clip(s / waist, 0.0, 1.0)
        cap = np.sqrt(np.clip(1 - (1 - np.clip(s / end, 0, 1)) ** 2, 0.0, 1.0))
        return np.maximum((end + (neck - end) * t * t * (3 - 2 * t)) * cap, 0.0008)

    return half


def _bow(s: np.ndarray, length: float, head: float, dip: float, tip: float) -> np.ndarray:
    """Return the height of the middle line: the handle arches, the neck dips, the head rises to its tip [m]."""
    t = s / length
    neck = 1 - head / length
    arch = dip * np.sin(np.pi * np.clip(t / neck, 0, 1)) * 0.9
    fall = -0.2 * dip * np.clip(t / neck, 0, 1)
    rise = np.clip((t - neck) / (1 - neck), 0, 1)
    return 0.004 + arch + fall - 0.006 * np.sin(np.pi * rise) + tip * 0.35 * rise**2


def _stamped(
    rng: np.random.Generator,
    wear: float,
    s: np.ndarray,
    y: np.ndarray,
    middle: np.ndarray,
    thickness: np.ndarray,
    present: np.ndarray | None,
    trough: float,
) -> Thing:
    """Return cutlery of sheet over the lines y (n, m) along it, with edges thinner than its middle."""
    middle = middle[:, None] if middle.ndim == 1 else middle
    widest = np.abs(y).max(1, keepdims=True)
    off = np.abs(y) / widest
    half = 0.5 * thickness[:, None] * (0.45 + 0.55 * np.sqrt(1 - 0.97 * off**2)) * np.ones_like(y)
    x = np.repeat(s[:, None], y.shape[1], axis=1)
    z = middle - trough * (1 - off**2)
    mesh = projected(sheet(np.stack([x, y, z + half], 2), np.stack([x, y, z - half], 2), present, np.radians(60.0)))
    return Thing((Part("cutlery", mesh, metal(rng, wear, "steel", 0.2)),))
