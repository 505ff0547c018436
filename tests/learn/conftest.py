from __future__ import annotations

import pytest
import torch


@pytest.fixture(scope="session", autouse=True)
def two_threads() -> None:
    """Tests share the machine: torch computes with two threads."""
    torch.set_num_threads(2)


@pytest.fixture(autouse=True)
def seeded() -> None:
    """The same weights in every test; tests must hold for any others as well."""
    torch.manual_seed(20230213)
