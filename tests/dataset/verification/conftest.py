"""A small data set with every label, rendered once."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from glassware.dataset.pipeline import write
from glassware.dataset.settings.draw import draw

#: One view of two vessels, one of them filled, and two props.
SEED = 11
SETTINGS = {
    "vessel_count": [2, 2],
    "prop_count": [2, 2],
    "vessels": {"chord_error": 2e-4, "fill_probability": 1.0},
    "cameras": {"width": 40, "height": 30, "views": 1},
    "picture": {"spp": 2, "denoise": False},
}


@pytest.fixture(scope="session")
def proven(made_once, backend) -> Path:
    """A data set of one view with all files; do not change it."""
    return made_once("proven", lambda folder: write(folder / "data", draw(SEED, 0, **SETTINGS), files="all")) / "data"


@pytest.fixture
def copy(proven, tmp_path) -> Path:
    """A copy of it."""
    return Path(shutil.copytree(proven, tmp_path / "data"))
