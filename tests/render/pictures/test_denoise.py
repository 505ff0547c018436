"""The denoiser takes noise off, and what it complains of is heard."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.render.pictures.denoise import denoise


def _even(height: int, width: int, value: float) -> np.ndarray:
    return np.full((height, width, 3), value, np.float32)


def test_noise_on_an_even_wall_goes(rng) -> None:
    noisy = (_even(64, 96, 0.5) * rng.uniform(0.5, 1.5, (64, 96, 1))).astype(np.float32)
    found = denoise(noisy, _even(64, 96, 0.5), _even(64, 96, 0.577))
    # A tenth of the deviation of 0.14 at most: it is told that colour and normal are even.
    assert found.std() < 0.014
    assert found.mean() == pytest.approx(noisy.mean(), rel=0.01)


def test_a_guide_of_another_size_is_an_error_and_no_black_picture() -> None:
    with pytest.raises(RuntimeError, match="Open Image Denoise"):
        denoise(_even(64, 96, 0.5), _even(32, 48, 0.5), _even(64, 96, 0.577))
