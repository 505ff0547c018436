"""What many tests share. Importing `glassware.render` here makes it choose LLVM before any test imports drjit."""

from __future__ import annotations

import importlib.util
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from filelock import FileLock

from glassware.render.backend.variant import activate

REPOSITORY = Path(__file__).resolve().parents[1]
#: Caches that libraries keep in the temp folder on purpose: compiled kernels of torch.
KEPT_IN_TEMP = ("torchinductor_",)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--part", help="i/n: of the files with chosen tests, only each n-th, from the i-th on")


@pytest.hookimpl(trylast=True)  # after `-m` has chosen
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep the chosen part of the files: what a file's tests share is then made once."""
    part = config.getoption("--part")
    if part is None:
        return
    number, parts = map(int, part.split("/"))
    if not 1 <= number <= parts:
        raise pytest.UsageError(f"--part: expected i/n with i from 1 to n, found {part}")
    files = set(sorted({item.path for item in items})[number - 1 :: parts])
    config.hook.pytest_deselected(items=[item for item in items if item.path not in files])
    items[:] = [item for item in items if item.path in files]


@pytest.fixture
def rng() -> np.random.Generator:
    """A generator with the same seed in every test; tests must hold for any other seed as well."""
    return np.random.default_rng(20230213)


@pytest.fixture(scope="session", autouse=True)
def temp_folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Temp files of the tests and of their child processes go to a folder of their own, which is empty in the end."""
    folder = tmp_path_factory.mktemp("temp")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TMPDIR", str(folder))
        patch.setattr(tempfile, "tempdir", None)  # it is looked up once
        yield
    left = sorted(path.name for path in folder.iterdir() if not path.name.startswith(KEPT_IN_TEMP))
    assert not left, "left in the temp folder"


@pytest.fixture(scope="session")
def made_once(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, Callable[[Path], None]], Path]:
    """(name, make) -> a folder that `make` fills once a run, for all processes of pytest-xdist; do not change it."""
    root = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        root = root.parent  # a process's own folder lies in that of the run

    def folder(name: str, make: Callable[[Path], None]) -> Path:
        path, done = root / f"once-{name}", root / f"once-{name}.done"
        with FileLock(root / f"once-{name}.lock"):
            if not done.exists():
                shutil.rmtree(path, ignore_errors=True)  # what an attempt that failed has left
                path.mkdir()
                make(path)
                done.touch()
        return path

    return folder


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
def own_shapes() -> ModuleType:
    """The module `tests/own_shapes.py`: solids as people bring them."""
    return _module("own_shapes")


@pytest.fixture(scope="session")
def media_rays() -> ModuleType:
    """The module `tests/media_rays.py`: crossings of rays with meshes, and winding numbers."""
    return _module("media_rays")


@pytest.fixture(scope="session")
def optical_bench() -> ModuleType:
    """The module `tests/optical_bench.py`: scenes of one glass body each."""
    return _module("optical_bench")


@pytest.fixture(scope="session")
def numpy_tracer() -> ModuleType:
    """The module `tests/numpy_tracer.py`: a second, independent refractive ray tracer."""
    return _module("numpy_tracer")


@pytest.fixture(scope="session")
def planes() -> ModuleType:
    """The module `tests/infrared_planes.py`: what a depth camera sees of planes, by closed forms."""
    return _module("infrared_planes")


@pytest.fixture(scope="session")
def makers() -> ModuleType:
    """The module `tests/source_makers.py`: small folders in other projects' layouts."""
    return _module("source_makers")


def _module(stem: str) -> ModuleType:
    """Import a module beside this file by its path, as all test files are."""
    name = f"glassware_tests_{stem}"
    spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name(f"{stem}.py"))
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module
