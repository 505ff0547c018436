"""Converged pictures, made in passes and kept on disk, and the error of others against them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console

#: Added to the squared reference, so that black pixels do not decide: a tenth of white, squared, in exposed units.
RELMSE_EPSILON = 0.01
#: Samples of one pass of a reference: enough for the sample points to spread, few enough to stop and go on.
PASS_SPP = 256
#: First seed of the references' passes; measured pictures take small seeds, so the two never share samples.
_REFERENCE_SEED = 1_000_000


@dataclass(frozen=True, eq=False)
class Reference:
    """A mean of passes in exposed linear units, and the variance of that mean."""

    picture: np.ndarray  #: (H, W, 3) float64
    variance: np.ndarray  #: (H, W, 3) float64, of the mean, from the spread of the passes
    passes: int

    @property
    def floor(self) -> float:
        """The relMSE that the reference's own noise would add to every figure."""
        return float((self.variance / (self.picture**2 + RELMSE_EPSILON)).mean())


def relmse(picture: np.ndarray, reference: Reference) -> float:
    """Return the mean of (I - R)^2 / (R^2 + 0.01) over pixels and channels, less what the reference's own noise adds.

    That noise is independent of the picture's, so its variance is what it adds on the average.

    Parameters
    ----------
    picture : (H, W, 3) float
        In exposed linear units (white is about 1), as the reference.
    reference : Reference
        The converged picture.
    """
    R = reference.picture
    return float(((picture - R) ** 2 / (R**2 + RELMSE_EPSILON)).mean()) - reference.floor


def reference(path: Path, spp: int, one_pass: Callable[[int], np.ndarray]) -> Reference:
    """Return the mean of at least `spp` samples, from the file as far as it goes and rendered from there on.

    Parameters
    ----------
    path : Path
        The ``.npz`` file; it is rewritten after every pass, so that nothing is lost when a run is stopped.
    spp : int
        Samples per pixel wanted, at least two passes of `PASS_SPP`.
    one_pass : callable
        Renders `PASS_SPP` samples in exposed linear units, (H, W, 3), from a seed.
    """
    passes, console = max(2, -(-spp // PASS_SPP)), Console(stderr=True)
    total, squares, done = _read(path)
    while done < passes:
        picture = np.asarray(one_pass(_REFERENCE_SEED + done), np.float64)
        total, squares, done = total + picture, squares + picture**2, done + 1
        _write(path, total, squares, done)
        console.print(f"reference {path.stem}: {done * PASS_SPP} of {passes * PASS_SPP} samples", highlight=False)
    mean = total / done
    spread = np.maximum(squares / done - mean**2, 0.0) * done / (done - 1)
    return Reference(np.asarray(mean), spread / done, done)


def _read(path: Path) -> tuple[np.ndarray | float, np.ndarray | float, int]:
    if not path.is_file():
        return 0.0, 0.0, 0
    with np.load(path, allow_pickle=False) as file:
        return file["total"], file["squares"], int(file["done"])


def _write(path: Path, total: np.ndarray, squares: np.ndarray, done: int) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    # Written beside and renamed: a stopped run leaves the last whole state.
    beside = path.with_suffix(".part.npz")
    np.savez(beside, total=total, squares=squares, done=done)
    beside.replace(path)
