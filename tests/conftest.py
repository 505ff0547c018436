"""What many tests share. Importing `glassware.render` here makes it choose LLVM before any test imports drjit."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from glassware.render.backend import activate

REPOSITORY = Path(__file__).resolve().parents[1]


@pytest.fixture
def rng() -> np.random.Generator:
    """A generator with the same seed in every test; tests must hold for any other seed as well."""
    return np.random.default_rng(20230213)


@pytest.fixture(scope="session")
def shared_assets() -> Path:
    """Real environment maps, meshes and textures, which lie beside the checkout and are never committed."""
    folder = REPOSITORY.parent / "shared" / "assets"
    if not folder.is_dir():
        pytest.skip("the folder shared/assets with real files is not beside this checkout")
    return folder


@pytest.fixture(scope="session")
def backend() -> str:
    """The variant that is the reference for reproducibility, active."""
    return activate("llvm_ad_rgb")


@pytest.fixture(scope="session")
def analytic() -> ModuleType:
    """The module `tests/analytic.py`, imported by path as all test files are: a scene of closed forms."""
    name = "glassware_tests_analytic"
    spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name("analytic.py"))
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module
