from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest


def _module():
    """Test files are imported by path, so the module they share is too."""
    name = "glassware_tests_analytic"
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, Path(__file__).parents[1] / "analytic.py")
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        spec.loader.exec_module(module)
    return sys.modules[name]


@pytest.fixture(scope="session")
def analytic():
    return _module()
