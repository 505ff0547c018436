"""A training run that goes on from a checkpoint of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import torch

from ...core.errors import InputError
from .checkpoint import Checkpoint, check_weights, data_digest, restore
from .prepare import Parts
from .settings import TrainSettings

#: Settings that may differ from the checkpoint's: they say where and how fast it runs, and what it tells.
_FREE = ("machine", "log_every", "pictures_every", "save_every")


def resumable(start: Checkpoint, settings: TrainSettings, data: Path, where: Path) -> Checkpoint:
    """Return a checkpoint that may go on, with what may differ as it is asked for; InputError where more differs."""
    if start.data is None or start.data.sha256 != data_digest(data):
        found = "none" if start.data is None else f"{start.data.name} with seed {start.data.seed} and other content"
        raise InputError(f"{where}: data set", f"that of {data}", found)
    asked, kept = settings.model_dump(mode="json"), start.settings.model_dump(mode="json")
    if asked["network"]["depth_range"] is None:
        asked["network"]["depth_range"] = kept["network"]["depth_range"]
    for name in sorted(asked.keys() - set(_FREE)):
        if asked[name] != kept[name]:
            raise InputError(f"{where}: {name}", f"{asked[name]}", f"{kept[name]} in the checkpoint")
    free = {name: getattr(settings, name) for name in _FREE}
    return replace(start, settings=start.settings.model_copy(update=free))


def restore_parts(parts: Parts, start: Checkpoint, where: Path) -> None:
    """Go on from a checkpoint; InputError where a part of it does not fit."""
    restore(parts.network, start.network, where)
    if start.ema is not None:
        check_weights(parts.network, start.ema, where)
    try:
        parts.optimiser.load_state_dict(start.optimiser)
        torch.set_rng_state(start.rng)
    except (ValueError, TypeError, KeyError, AttributeError, RuntimeError) as error:
        found = (str(error) or type(error).__name__).splitlines()[0]
        raise InputError(f"{where}: optimiser and rng", "the states of these settings", found) from error
    known = [value in parts.optimiser.state for group in parts.optimiser.param_groups for value in group["params"]]
    if start.step and not all(known):
        raise InputError(f"{where}: optimiser", f"a state of {len(known)} weights", f"one of {sum(known)}")
