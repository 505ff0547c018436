"""Soft mattes: against each other, against masks and transmittance, and by other rays through the stored meshes."""

from __future__ import annotations

import cv2
import numpy as np

from ...annotate.mattes import Mattes
from ...render.frame import Geometry
from ..format import layout
from .fault import Fault, at_pixels
from .pinhole import Pinhole
from .raycast import cast
from .triangles import Triangles
from .truth import without_lamps

#: Rounding of halves up to 1, and of sums of a few.
_HALF = 2e-3
#: Rays of a pixel along each side, pixels that are traced again, and how far two estimates of a fraction may differ:
#: 16 and 64 stratified rays across an edge differ by 0.04 in the mean, and by 0.2 where several edges meet.
_SIDE, _PIXELS, _AWAY = 8, 200, 0.25
#: Pixels whose neighbours are all alike and that are not what these are [fraction]: things thinner than a pixel.
_THIN = 0.02


def matte_contradictions(mattes: Mattes, total: np.ndarray, geometry: Geometry) -> list[Fault]:
    """Compare mattes with each other, with the masks of pixel centres, and with the transmittance of the straight rays.

    Parameters
    ----------
    mattes : Mattes
        As stored.
    total : (H, W) float
        Fraction of each pixel with any surface, ``A``.
    geometry : Geometry
        Of the pixels' centres.
    """
    file, shape = layout.MATTES, geometry.Z.shape
    for values, name in ((mattes.coverage, "coverage"), (mattes.transmittance, "transmittance"), (total[None], "A")):
        if values.min(initial=0.0) >= 0.0 and values.max(initial=0.0) <= 1.0 + _HALF:  # false of NaN as well
            continue
        outside = ~((values >= 0.0) & (values <= 1.0 + _HALF)).reshape(len(values), *shape, -1)
        wrong = np.asarray(outside.any(axis=(0, 3)))
        return at_pixels(f"mattes {name}", file, wrong, "numbers from 0 to 1", np.moveaxis(values, 0, 2))
    for place, number in enumerate(mattes.ids):
        coverage, mask = mattes.coverage[place], geometry.reached[place]
        inside, outside = _all_alike(mask), _all_alike(~mask)
        wrong = (inside & (coverage < 0.5)) | (outside & (coverage > 0.5))
        if wrong.sum() > _THIN * mask.sum() + 2:
            return at_pixels(f"mattes coverage {number}", file, wrong, "that of the mask", coverage)
    return _product_faults(mattes, geometry)


def cryptomatte_contradictions(mattes: Mattes, total: np.ndarray, geometry: Geometry) -> list[Fault]:
    """Compare the fractions of first surfaces with their sum, with the coverage, and with the ids of pixel centres."""
    file, ids = layout.CRYPTOMATTE, geometry.id
    first = np.sum([*mattes.first.values(), np.zeros(ids.shape, np.float32)], axis=0)
    found = at_pixels("mattes first", file, np.abs(first - total) > _HALF, total, first)
    for place, number in enumerate(mattes.ids):
        mine = mattes.first.get(number, np.zeros(ids.shape, np.float32))
        more = mine > mattes.coverage[place] + _HALF
        alone = _all_alike(ids == number) & (mine < 0.5)
        if more.any() or alone.sum() > _THIN * (ids == number).sum() + 2:
            found += at_pixels(f"mattes first {number}", file, more | alone, mattes.coverage[place], mine)
    return found


def matte_faults(mattes: Mattes, camera: Pinhole, triangles: Triangles, rng: np.random.Generator) -> list[Fault]:
    """Trace a grid of rays through random pixels at edges, and some others, and compare the fractions of objects."""
    partial = ((mattes.coverage > 0.0) & (mattes.coverage < 1.0)).any(axis=0)
    picked = rng.permutation(np.flatnonzero(partial.ravel()))[: _PIXELS - _PIXELS // 8]
    picked = np.concatenate([picked, rng.integers(0, partial.size, _PIXELS // 8)])
    steps = (np.indices((_SIDE, _SIDE)).reshape(2, -1).T + 0.5) / _SIDE - 0.5
    width = camera.size[0]
    pixels = np.stack([picked % width, picked // width], axis=1)[:, None] + steps
    hits = without_lamps(triangles, cast(triangles, camera, pixels.reshape(-1, 2)))
    ids, opaque = triangles.id[hits.triangle], triangles.opaque[hits.triangle]
    # Surfaces before the first opaque one of their ray, and that one itself.
    start = np.searchsorted(hits.ray, np.arange(hits.count))
    before = np.cumsum(opaque) - opaque
    clear = before == before[start[hits.ray]] if len(hits.ray) else np.zeros(0, bool)
    for place, number in enumerate(mattes.ids):
        seen = np.zeros(hits.count, bool)
        seen[hits.ray[clear & (ids == number)]] = True
        expected = seen.reshape(len(picked), -1).mean(axis=1)
        stored = mattes.coverage[place].ravel()[picked]
        wrong, shown = np.zeros(partial.size, bool), np.zeros(partial.size)
        wrong[picked], shown[picked] = np.abs(stored - expected) > _AWAY, expected
        if wrong.sum() > 0.01 * len(picked):
            check, shape = f"mattes coverage {number}", partial.shape
            return at_pixels(check, layout.MATTES, wrong.reshape(shape), shown.reshape(shape), mattes.coverage[place])
    return []


def _product_faults(mattes: Mattes, geometry: Geometry) -> list[Fault]:
    """Compare the product of what all transparent objects pass on with the transmittance of the pixel's centre."""
    covered, passed = mattes.coverage, mattes.transmittance
    clear = [place for place in range(len(passed)) if (passed[place] > 0.0).any()]
    # A turbid liquid is opaque: its own vessel passes on nothing, but the ray has reached it. Pixels beside such ones
    # show a part of it.
    turbid = np.isin(geometry.background_id, [mattes.ids[place] for place in clear])
    checked = (geometry.id > 1) & _all_alike(~turbid)
    for coverage in covered:
        checked &= (coverage < _HALF) | (coverage > 1.0 - _HALF)
    product = np.ones(geometry.transmittance.shape, np.float32)
    for place in clear:
        product[checked] *= passed[place][checked]
    # Over a pixel the transmittance lies between its neighbours', but where something changes.
    kernel = np.ones((3, 3))
    low, high = (change(geometry.transmittance, kernel) for change in (cv2.erode, cv2.dilate))
    slack = 0.02 + (high - low)
    wrong = checked & ((product < low - slack) | (product > high + slack)).any(axis=-1)
    if wrong.sum() <= _THIN * checked.sum() + 2:
        return []
    return at_pixels("mattes transmittance", layout.MATTES, wrong, geometry.transmittance, product)


def _all_alike(mask: np.ndarray) -> np.ndarray:
    """Return the pixels of a mask whose eight neighbours are in it as well; beyond the picture all are."""
    return cv2.erode(mask.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
