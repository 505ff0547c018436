"""The measurements of `tests/proofs`, imported by path, at budgets of a test."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Callable
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType

import pytest

PROOFS = Path(__file__).resolve().parents[2] / "proofs"


@pytest.fixture
def law(backend: str) -> Callable[[str], ModuleType]:
    """Name -> the module of `tests/proofs`."""
    package = "glassware_proofs"
    if package not in sys.modules:
        spec = ModuleSpec(package, None, is_package=True)
        spec.submodule_search_locations = [str(PROOFS)]
        sys.modules[package] = importlib.util.module_from_spec(spec)
    return lambda name: importlib.import_module(f"{package}.{name}")


@pytest.fixture
def holds() -> Callable[[list], None]:
    """Assert that what is measured differs from the law by no more than rounding, facets and noise explain."""

    def check_all(checks: list) -> None:
        assert checks
        for check in checks:
            assert check.share <= 1.0, f"{check.name}: {check.share:g} of what is explained; {check}"

    return check_all


@pytest.fixture
def broken() -> Callable[[list], bool]:
    """Tell whether any measurement differs by more."""
    return lambda checks: any(check.share > 1.0 for check in checks)
