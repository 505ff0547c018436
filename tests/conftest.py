"""What many tests share. Importing `glassware.render` here makes it choose LLVM before any test imports drjit."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from glassware.render.backend.variant import activate

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
    """The module `tests/analytic.py`: a scene of closed forms."""
    return _module("analytic")


@pytest.fixture(scope="session")
def optical_bench() -> ModuleType:
    """The module `tests/optical_bench.py`: scenes of one glass body each."""
    return _module("optical_bench")


@pytest.fixture(scope="session")
def numpy_tracer() -> ModuleType:
    """The module `tests/numpy_tracer.py`: a second, independent refractive ray tracer."""
    return _module("numpy_tracer")


def _module(stem: str) -> ModuleType:
    """Import a module beside this file by its path, as all test files are."""
    name = f"glassware_tests_{stem}"
    spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name(f"{stem}.py"))
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module
