"""A training run: step after step, and what is kept of it.

The loop is ours, on Lightning's Fabric, which knows devices, precision and processes. What a step takes follows from
its number alone, so a run that is stopped and goes on from a checkpoint gives the weights of one that was not stopped.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import torch
from torch import Tensor

from ...core.errors import InputError
from ...core.exit_codes import WorkFailed
from ...core.stopping import check_stop
from ...dataset.reader import Dataset
from ..data.loading import load_batches
from ..data.samples import Batch, batched
from ..networks.build import Network, build_network
from .checkpoint import Checkpoint, load_checkpoint, save_checkpoint
from .losses import losses, total_loss
from .out_folder import made_folder
from .prepare import Parts, load_first_weights, prepared
from .resume import restore_parts, resumable
from .run_log import Records
from .schedule import StepBatches, rate_at
from .settings import TrainSettings

#: Files of a run: the latest state, and that with the least validation loss.
LAST, BEST = "last.ckpt", "best.ckpt"
#: Validation samples are drawn once.
_VALIDATION_DRAW = 0


def train(settings: TrainSettings, data: Path, out: Path, resume: Path | None, say: Callable[[str], None]) -> None:
    """Train a network and write its checkpoints.

    Parameters
    ----------
    settings : TrainSettings
        How.
    data : Path
        The data set.
    out : Path
        Folder of the run: ``last.ckpt``, ``best.ckpt`` and the logs for TensorBoard.
    resume : Path, optional
        A checkpoint of the same settings and data set to go on from.
    say : callable
        Takes lines about the progress.

    Raises
    ------
    InputError
        For wrong data or settings.
    WorkFailed
        Where a loss or a gradient is no longer a number.
    """
    Dataset.open(data)
    start = None if resume is None else resumable(load_checkpoint(resume), settings, data, resume)
    if (out / LAST).exists() and (resume is None or resume.resolve().parent != out.resolve()):
        raise InputError(out, f"a folder without {LAST} (or --resume {out / LAST})", "one of an earlier run")
    made_folder(out)
    if settings.machine.threads is not None:
        torch.set_num_threads(settings.machine.threads)
    parts = prepared(settings if start is None else start.settings, data, out)
    if start is None:
        load_first_weights(parts)
        state = _first(parts)
    else:
        restore_parts(parts, start, resume or out)
        state = start
    _steps(parts, state, say)


def _first(parts: Parts) -> Checkpoint:
    ema = _weights(parts.network) if parts.settings.optimiser.ema else None
    return _state(parts, 0, ema, math.inf)


def _state(parts: Parts, step: int, ema: dict[str, Tensor] | None, best: float) -> Checkpoint:
    network, optimiser = _weights(parts.network), parts.optimiser.state_dict()
    return Checkpoint(parts.settings, parts.data, step, network, ema, optimiser, torch.get_rng_state(), best)


def _weights(network: Network) -> dict[str, Tensor]:
    return {name: value.detach().clone() for name, value in network.state_dict().items()}


def _steps(parts: Parts, start: Checkpoint, say: Callable[[str], None]) -> None:
    settings, fabric = parts.settings, parts.fabric
    model, optimiser = fabric.setup(parts.network, parts.optimiser)
    todo = range(start.step, settings.steps)
    order = StepBatches(len(parts.train), settings.batch, todo, settings.seed, fabric.global_rank, fabric.world_size)
    loader = load_batches(parts.train, order, settings.machine.workers)
    ema = None if start.ema is None else {name: value.to(fabric.device) for name, value in start.ema.items()}
    best = start.best
    records = Records(parts.out, start.step, settings, fabric, say)
    for step, batch in zip(todo, loader, strict=True):
        check_stop()
        for group in optimiser.param_groups:
            group["lr"] = rate_at(step, settings.steps, settings.optimiser)
        moved = batch.to(fabric.device)
        model.train()
        outputs = model(moved.images, moved.world_T_camera, moved.K)
        found = losses(outputs, moved.targets, settings.network, settings.losses.huber)
        total = total_loss(found, settings.losses)
        _check_loss(total, found, step, batch)
        optimiser.zero_grad(set_to_none=True)
        fabric.backward(total)
        norm = fabric.clip_gradients(model, optimiser, max_norm=settings.optimiser.clip, error_if_nonfinite=False)
        _check_gradient(norm, step, batch)
        optimiser.step()
        ema = _averaged(ema, parts.network, settings.optimiser.ema)
        done = step + 1
        records.step(done, total, found, optimiser.param_groups[0]["lr"], moved, outputs)
        if parts.val is not None and (done % settings.validate_every == 0 or done == settings.steps):
            loss = validated(parts, ema)
            if not math.isfinite(loss):
                raise WorkFailed(f"validation loss of step {done}: expected a finite number, found {loss:g}")
            records.validation(done, loss)
            if loss < best:
                best = loss
                _save(parts, BEST, done, ema, best)
        if done % settings.save_every == 0 or done == settings.steps:
            _save(parts, LAST, done, ema, best)
    records.close()
    if fabric.is_global_zero:
        say(f"{parts.out}: trained for {settings.steps} steps")


def _save(parts: Parts, name: str, step: int, ema: dict[str, Tensor] | None, best: float) -> None:
    if parts.fabric.is_global_zero:
        save_checkpoint(parts.out / name, _state(parts, step, ema, best))


def _averaged(ema: dict[str, Tensor] | None, network: Network, decay: float) -> dict[str, Tensor] | None:
    """Return the mean of the weights after a step; counters and statistics of batches are the newest."""
    if ema is None:
        return None
    learnt = {name for name, _ in network.named_parameters()}
    with torch.no_grad():
        return {
            name: torch.lerp(value, ema[name], decay) if name in learnt else value.clone()
            for name, value in _weights(network).items()
        }


def _check_loss(total: Tensor, found: dict[str, Tensor], step: int, batch: Batch) -> None:
    if not bool(torch.isfinite(total)):
        wrong = [f"{name} {float(value.detach()):g}" for name, value in found.items() if not torch.isfinite(value)]
        where = f"loss of step {step} on {', '.join(batch.names)}"
        raise WorkFailed(f"{where}: expected a finite number, found {float(total.detach()):g} ({', '.join(wrong)})")


def _check_gradient(norm: Tensor | None, step: int, batch: Batch) -> None:
    if norm is not None and not bool(torch.isfinite(norm)):
        where = f"gradient of step {step} on {', '.join(batch.names)}"
        raise WorkFailed(f"{where}: expected a finite norm, found {float(norm):g}")


def validated(parts: Parts, ema: dict[str, Tensor] | None) -> float:
    """Return the mean loss over validation samples, with the weights that would be used and without changing any."""
    assert parts.val is not None
    with torch.random.fork_rng(devices=[]):  # its first weights are thrown away
        network = build_network(parts.settings.network).to(parts.fabric.device)
    network.load_state_dict(parts.network.state_dict() if ema is None else ema)
    network.eval()
    weights = parts.settings.losses
    count = min(len(parts.val), parts.settings.validate_samples)
    spread = [index * len(parts.val) // count for index in range(count)]
    values = []
    with torch.inference_mode():
        for index in spread:
            batch = batched([parts.val[(index, _VALIDATION_DRAW)]]).to(parts.fabric.device)
            outputs = network(batch.images, batch.world_T_camera, batch.K)
            found = losses(outputs, batch.targets, parts.settings.network, weights.huber)
            values.append(float(total_loss(found, weights)))
    return sum(values) / count
