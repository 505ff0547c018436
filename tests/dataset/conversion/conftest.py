from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest


@pytest.fixture(scope="session")
def makers() -> ModuleType:
    """The module `tests/source_makers.py`: small folders in other projects' layouts."""
    path = Path(__file__).resolve().parents[2] / "source_makers.py"
    spec = importlib.util.spec_from_file_location("source_makers", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
