from __future__ import annotations

import pytest

from glassware.learn.training.settings import MachineSettings, OptimiserSettings, TrainSettings


@pytest.fixture
def settings(tiny) -> TrainSettings:
    """A run of some steps on the first scene."""
    return TrainSettings(
        network=tiny.model_copy(update={"depth_range": None}),
        machine=MachineSettings(accelerator="cpu", workers=0, threads=1),
        optimiser=OptimiserSettings(warmup=2, ema=0.5),
        steps=6,
        batch=2,
        save_every=3,
        validate_every=3,
        validate_samples=2,
        log_every=1,
        pictures_every=6,
    )
