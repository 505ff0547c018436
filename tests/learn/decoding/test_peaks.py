from __future__ import annotations

import numpy as np
import torch

from glassware.learn.decoding.peaks import MIN_DISTANCE, find_peaks


def by_hand(heat: np.ndarray, threshold: float) -> list[tuple[int, int, float]]:
    """Peaks by going through every pixel and its square, by falling heat."""
    found = []
    for y, x in np.ndindex(heat.shape):
        rows = slice(max(y - MIN_DISTANCE, 0), y + MIN_DISTANCE + 1)
        columns = slice(max(x - MIN_DISTANCE, 0), x + MIN_DISTANCE + 1)
        if heat[y, x] > threshold and heat[y, x] == heat[rows, columns].max():
            found.append((x, y, float(heat[y, x])))
    return sorted(found, key=lambda row: -row[2])


def test_peaks_are_those_found_pixel_by_pixel(rng):
    heat = rng.uniform(0, 1, (3, 40, 50)).astype(np.float32)
    peaks = find_peaks(torch.from_numpy(heat))
    for sample in range(3):
        rows = peaks.sample == sample
        ours = [(*at, score) for at, score in zip(peaks.pixel[rows].tolist(), peaks.score[rows].tolist(), strict=True)]
        assert ours == by_hand(heat[sample], 0.3)


def test_a_level_top_is_one_peak():
    heat = torch.zeros(1, 20, 30)
    heat[0, 6:9, 10:13] = 0.8
    peaks = find_peaks(heat)
    assert peaks.pixel.tolist() == [[10.0, 6.0]]


def test_what_is_under_the_threshold_is_no_peak():
    heat = torch.zeros(2, 20, 30)
    heat[0, 3, 3], heat[1, 4, 5] = 0.29, 0.31
    peaks = find_peaks(heat)
    assert peaks.sample.tolist() == [1]
    assert peaks.pixel.tolist() == [[5.0, 4.0]]
