"""The training loop, its checkpoints and its validation.

The loop is our own, on Lightning Fabric, which handles devices, precision and processes. Each step depends on its
number alone, so a run that is stopped and resumed from a checkpoint gives the weights of an uninterrupted run.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import torch
from lightning_fabric import Fabric
from torch import Tensor

from ...core.errors import InputError
from ...core.exit_codes import WorkFailed
from ...core.stopping import check_stop
from ...dataset.reader import Dataset
from ..data.loading import load_batches
from ..data.samples import Batch, collate
from ..networks.build import Network, build_network
from .checkpoint import Checkpoint, load_checkpoint, load_trained, save_checkpoint
from .frozen import set_training_mode
from .initial_weights import load_initial_weights
from .losses import total_loss
from .methods import losses_of, note_step, outputs_of, with_own_views
from .out_folder import locked_out_folder
from .run_log import RunLog
from .schedule import StepBatches, learning_rate_at
from .settings import TrainSettings
from .train_state import (
    TrainState,
    load_pretrained_context,
    optimiser_tensors,
    restore_train_state,
    resumed_checkpoint,
    set_up_training,
    with_network_of,
)
from .used_settings import check_used

#: Checkpoints of a run: the latest state, and the one with the least validation loss.
LAST, BEST = "last.safetensors", "best.safetensors"
#: Validation samples are drawn once, so that losses compare.
_VALIDATION_DRAW = 0


def train(
    settings: TrainSettings,
    data: Path,
    out: Path,
    resume: Path | None,
    say: Callable[[str], None],
    init: Path | None = None,
    typed: Sequence[str] = (),
) -> None:
    """Train a network and write its checkpoints.

    Parameters
    ----------
    settings : TrainSettings
        Network, data, losses, optimiser, machine.
    data : Path
        The data set.
    out : Path
        Folder of the run: checkpoints `LAST` and `BEST`, and the TensorBoard log.
    resume : Path, optional
        A checkpoint to resume from, of the same settings and data set; of network and views, what the settings leave
        open is the checkpoint's.
    say : callable
        Takes lines about the progress.
    init : Path, optional
        A checkpoint, or weights by name, whose network a new run begins with, on this data set and with these settings.

    typed : sequence of str
        Names of settings that were typed for this run: they must have an effect (`used_settings`).

    Raises
    ------
    InputError
        For wrong data or settings.
    WorkFailed
        Where a loss or a gradient is not finite.
    """
    Dataset.open(data)
    requested = settings
    if init is not None and resume is not None:
        expected = "none beside resume: the checkpoint goes on with the network that its run began with"
        raise InputError("init", expected, init)
    weights = None if init is None else load_trained(init)
    if init is not None and weights is not None:
        settings = with_network_of(settings, weights.settings, init)
    settings = with_own_views(settings)
    start = None if resume is None else resumed_checkpoint(load_checkpoint(resume), settings, data, resume)
    settings = settings if start is None else start.settings
    check_used(typed, requested, settings)
    with locked_out_folder(out, say):
        if (out / LAST).exists() and (resume is None or resume.resolve().parent != out.resolve()):
            raise InputError(out, f"a folder without {LAST} (or --resume {out / LAST})", "one of an earlier run")
        if settings.machine.threads is not None:
            torch.set_num_threads(settings.machine.threads)
        state = set_up_training(settings, data, out)
        _check_samples(state, data)
        if start is None:
            if init is not None and weights is not None:
                load_initial_weights(state.network, weights, init)
            else:
                load_pretrained_context(state)
            start = _initial_checkpoint(state)
        else:
            restore_train_state(state, start, resume or out)
        _train_steps(state, start, say)


def _check_samples(state: TrainState, data: Path) -> None:
    """Refuse a split without a sample, such as one of objects that are all hidden, before anything is trained."""
    for split, samples in ((state.settings.train_split, state.train), (state.settings.val_split, state.val)):
        if samples is not None and len(samples) == 0:
            network = state.settings.network.name
            expected = f"a sample for the network {network} (a network of single objects learns from visible ones)"
            raise InputError(f"{data}: split {split}", expected, "none")


def _train_steps(state: TrainState, start: Checkpoint, say: Callable[[str], None]) -> None:
    settings, fabric = state.settings, state.fabric
    model, optimiser = fabric.setup(state.network, state.optimiser)
    steps = range(start.step, settings.steps)
    order = StepBatches(len(state.train), settings.batch, steps, settings.seed, fabric.global_rank, fabric.world_size)
    loader = load_batches(state.train, order, settings.machine.workers)
    ema = None if start.ema is None else {name: value.to(fabric.device) for name, value in start.ema.items()}
    best_loss = start.best_loss
    log = RunLog(state.out, start.step, settings, fabric, say)
    for step, loaded in zip(steps, loader, strict=True):
        check_stop()
        for group in optimiser.param_groups:
            group["lr"] = learning_rate_at(step, settings.steps, settings.optimiser)
        batch = loaded.to(fabric.device)
        set_training_mode(state.network, settings.optimiser.frozen)
        progress = step / settings.steps
        outputs = outputs_of(model, batch, settings.network, progress)
        terms = losses_of(outputs, batch, settings, progress)
        total = total_loss(terms, settings.losses)
        optimiser.zero_grad(set_to_none=True)
        fabric.backward(total)
        norm = fabric.clip_gradients(model, optimiser, max_norm=settings.optimiser.clip, error_if_nonfinite=False)
        check_finite(fabric, total, norm, terms, step, batch)
        optimiser.step()
        note_step(state.network, outputs)
        ema = _updated_ema(ema, state.network, settings.optimiser.ema)
        done = step + 1
        log.log_step(done, total, terms, optimiser.param_groups[0]["lr"], norm, batch, outputs)
        if state.val is not None and (done % settings.validate_every == 0 or done == settings.steps):
            loss = validate(state, ema)
            if not math.isfinite(loss):
                raise WorkFailed(f"validation loss of step {done}: expected a finite number, found {loss:g}")
            log.log_validation(done, loss)
            if loss < best_loss:
                best_loss = loss
                _save(state, BEST, done, ema, best_loss)
        if done % settings.save_every == 0 or done == settings.steps:
            _save(state, LAST, done, ema, best_loss)
    log.close()
    if fabric.is_global_zero:
        say(f"{state.out}: trained for {settings.steps} steps")


def validate(state: TrainState, ema: dict[str, Tensor] | None) -> float:
    """Run a copy of the network on the validation samples and return the mean loss; the network itself is unchanged.

    Each process takes its part of the samples, and all return the same mean.
    """
    assert state.val is not None
    with torch.random.fork_rng(devices=[]):  # its initial weights are replaced
        network = build_network(state.settings.network).to(state.fabric.device)
    # Batch statistics differ between processes; those of the first are saved.
    network.load_state_dict(state.fabric.broadcast(state.network.state_dict() if ema is None else ema))
    network.eval()
    weights = state.settings.losses
    count = min(len(state.val), state.settings.validate_samples)
    evenly_spaced = [index * len(state.val) // count for index in range(count)]
    fabric, values = state.fabric, []
    with torch.inference_mode():
        for index in evenly_spaced[fabric.global_rank :: fabric.world_size]:
            batch = collate([state.val[(index, _VALIDATION_DRAW)]]).to(fabric.device)
            outputs = outputs_of(network, batch, state.settings.network)
            terms = losses_of(outputs, batch, state.settings)
            values.append(float(total_loss(terms, weights)))
    own = torch.tensor(sum(values), dtype=torch.float64, device=fabric.device)
    return _summed(fabric, own) / count


def _summed(fabric: Fabric, value: Tensor) -> float:
    """Return the sum of a number over all processes."""
    whole = value if fabric.world_size == 1 else fabric.all_reduce(value, reduce_op="sum")
    assert isinstance(whole, Tensor)
    return float(whole)


def _initial_checkpoint(state: TrainState) -> Checkpoint:
    ema = _weights(state.network) if state.settings.optimiser.ema else None
    return _checkpoint(state, 0, ema, math.inf)


def _save(state: TrainState, name: str, step: int, ema: dict[str, Tensor] | None, best_loss: float) -> None:
    if state.fabric.is_global_zero:
        save_checkpoint(state.out / name, _checkpoint(state, step, ema, best_loss))


def _checkpoint(state: TrainState, step: int, ema: dict[str, Tensor] | None, best_loss: float) -> Checkpoint:
    return Checkpoint(
        settings=state.settings,
        data=state.data,
        step=step,
        network=_weights(state.network),
        ema=ema,
        optimiser=optimiser_tensors(state.optimiser),
        rng=torch.get_rng_state(),
        best_loss=best_loss,
    )


def _weights(network: Network) -> dict[str, Tensor]:
    return {name: value.detach().clone() for name, value in network.state_dict().items()}


def _updated_ema(ema: dict[str, Tensor] | None, network: Network, decay: float) -> dict[str, Tensor] | None:
    """Return the moving average of the weights after a step; counters and batch statistics are the newest."""
    if ema is None:
        return None
    learnt = {name for name, _ in network.named_parameters()}
    with torch.no_grad():
        return {
            name: torch.lerp(value, ema[name], decay) if name in learnt else value.clone()
            for name, value in _weights(network).items()
        }


def check_finite(
    fabric: Fabric, total: Tensor, norm: Tensor | None, terms: dict[str, Tensor], step: int, batch: Batch
) -> None:
    """Raise WorkFailed in all processes where the loss or the gradient of one is not finite.

    Both are looked at once, after the gradient: each look waits for the device, and a process that stopped before it
    has given its gradient would leave the others waiting.
    """
    loss = total.detach()
    finite = torch.isfinite(loss) if norm is None else torch.isfinite(loss) & torch.isfinite(norm)
    if _summed(fabric, finite.float()) == fabric.world_size:
        return
    names = ", ".join(batch.names)
    if not bool(torch.isfinite(loss)):
        wrong = [f"{name} {float(value.detach()):g}" for name, value in terms.items() if not torch.isfinite(value)]
        where = f"loss of step {step} on {names}"
        raise WorkFailed(f"{where}: expected a finite number, found {float(loss):g} ({', '.join(wrong)})")
    found = "another, of another process" if norm is None or bool(torch.isfinite(norm)) else f"{float(norm):g}"
    raise WorkFailed(f"gradient of step {step} on {names}: expected a finite norm, found {found}")
