"""Training and evaluation of the rows of a table; what is done is kept, and interrupted runs go on."""

from __future__ import annotations

import platform
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any, Literal

import torch
from pydantic import Field
from torch.utils.flop_counter import FlopCounterMode

from ...core.atomic_io import write_atomically
from ...core.errors import InputError
from ...core.json_file import json_text, parsed, read_json
from ...core.model import Model
from ...core.stopping import check_stop
from ...dataset.format.checksums import Sha256, file_digest
from ...dataset.reader import Dataset
from ..data.dataset_digest import dataset_digest
from ..data.samples import collate
from ..data.splits import SplitName, scenes_of
from ..evaluation.run import evaluate
from ..networks.settings import NetworkName
from ..training.checkpoint import load_checkpoint, load_network
from ..training.losses import total_loss
from ..training.methods import losses_of, outputs_of, samples_of, with_own_views
from ..training.run import BEST, LAST, train
from ..training.settings import TrainSettings
from ..training.train_state import set_up_training
from .experiments import DETECTOR, Experiment, Row, row_settings

#: Samples that the paper's networks see: 400,000 steps of 5 (released settings of two views).
PAPER_SAMPLES = 2_000_000
#: Fraction of a budget that is left for loading, validation and evaluation.
_OVERHEAD = 0.25
#: Steps that are measured, after one that is not.
_MEASURED = 2
#: Least steps of a run.
_FEWEST_STEPS = 2
PLAN, PLAN_SCHEMA = "plan.json", "glassware/tables-plan/1"


class GivenWeights(Model):
    """Weights that are evaluated in place of training a row."""

    path: str
    sha256: Sha256


class Plan(Model):
    """What a table is made of; written before the first run, so that a later call goes on with the same."""

    schema_version: Literal["glassware/tables-plan/1"] = PLAN_SCHEMA
    experiment: str
    data: str = Field(description="Digest of the data set")
    settings: TrainSettings = Field(description="Common settings")
    seeds: int
    split: SplitName
    budget: float | None = Field(description="Minutes of training; null: none was given")
    samples: int = Field(description="Samples that each run sees")
    seconds: dict[str, float] = Field(description="Measured time of a training step of each row, by budget [s]")
    machine: str
    checkpoints: dict[str, GivenWeights | None] = Field(
        default={}, description="Of each row that was begun: the weights that were given, or null where it is trained"
    )


@dataclass(frozen=True)
class Result:
    """What is known of a row."""

    reports: tuple[Mapping[str, Any], ...]  #: of each seed
    reason: str = ""  #: why it was not run, or whose runs these are
    facts: Mapping[str, float] | None = None  #: parameters, gmac, samples seen, steps, seconds of a step


def make_plan(
    what: Experiment,
    common: TrainSettings,
    data: Path,
    out: Path,
    *,
    budget: float | None,
    samples: int | None,
    seeds: int,
    split: SplitName,
    rows: Sequence[Row],
    say: Callable[[str], None],
) -> Plan:
    """Return the plan of a folder, or make one and write it; InputError where the folder has another.

    Every run sees the same number of samples: those that are asked for; with a budget so many that all runs together
    take that time on this machine, by two measured steps of each; or else as many as the paper's.
    """
    if samples is not None and (samples % common.batch or samples < _FEWEST_STEPS * common.batch):
        expected = f"a multiple of the batch, {common.batch}, of {_FEWEST_STEPS * common.batch} or more"
        raise InputError("samples", expected, samples)
    splits: list[SplitName] = [common.train_split, split]
    if common.val_split != "none":
        splits.append(common.val_split)
    for name in splits:
        scenes_of(Dataset.open(data), name)
    digest = dataset_digest(data)
    path = out / PLAN
    if path.is_file():
        plan = parsed(Plan, read_json(path), path)
        seen = plan.samples if budget is not None else samples or PAPER_SAMPLES
        wanted = {"experiment": what.name, "data": digest, "settings": common, "seeds": seeds, "split": split}
        wanted |= {"budget": budget, "samples": seen}
        other = [name for name, value in wanted.items() if getattr(plan, name) != value]
        if other:
            expected = f"the plan of the same experiment, with the same {', '.join(other)} (or another --out)"
            raise InputError(path, expected, "another")
        return plan
    seconds: dict[str, float] = {}
    seen = samples or PAPER_SAMPLES
    if budget is not None:
        for row in rows:
            seconds[row.name] = _step_seconds(row, common, data)
            say(f"{row.title}: {seconds[row.name]:.2f} s a step")
        whole = seeds * sum(seconds.values())
        steps = max(_FEWEST_STEPS, int(60.0 * budget * (1.0 - _OVERHEAD) / whole)) if whole else _FEWEST_STEPS
        seen = min(steps * common.batch, PAPER_SAMPLES)
    plan = Plan(
        experiment=what.name,
        data=digest,
        settings=common,
        seeds=seeds,
        split=split,
        budget=budget,
        samples=seen,
        seconds=seconds,
        machine=f"{platform.machine()}, {torch.get_num_threads()} threads, torch {torch.__version__}",
    )
    write_atomically(path, json_text(plan.model_dump(mode="json")).encode())
    return plan


def with_checkpoints(plan: Plan, out: Path, rows: Sequence[Row], given: Mapping[str, Path]) -> Plan:
    """Return the plan of a folder with the weights of the rows of a call, and write it.

    Raises
    ------
    InputError
        Where a row was begun with other weights: its report, and rows that are told by it where objects are, would be
        of both.
    """
    weights = {name: GivenWeights(path=str(path), sha256=file_digest(path)) for name, path in given.items()}
    own = [row.name for row in rows] + [name for name in plan.checkpoints if name == DETECTOR]
    wanted: dict[str, GivenWeights | None] = {**dict.fromkeys(own), **weights}
    for name, new in wanted.items():
        old = plan.checkpoints.get(name, new)
        if (old and old.sha256) != (new and new.sha256):
            earlier = "none, as it is trained here" if old is None else f"{name}={old.path}, as an earlier call has it"
            found = "none" if new is None else f"{name}={new.path}{', of other content' if old else ''}"
            raise InputError(f"{out / PLAN}: checkpoints", f"{earlier} (or another --out)", found)
    plan = plan.model_copy(update={"checkpoints": wanted | dict(plan.checkpoints)})
    write_atomically(out / PLAN, json_text(plan.model_dump(mode="json")).encode())
    return plan


def run_row(
    row: Row,
    plan: Plan,
    data: Path,
    out: Path,
    *,
    given: Path | None,
    detectors: Mapping[int, Path],
    say: Callable[[str], None],
) -> Result:
    """Train a row for each seed and evaluate it, or what of that is left to do; or evaluate a given checkpoint."""
    reports, facts = [], {}
    for seed in range(plan.seeds if given is None else 1):
        check_stop()
        folder = out / "runs" / f"{row.name}-{seed}"
        if row.needs_detector and seed not in detectors:
            return Result((), "not run: no network to complete depth")
        checkpoint = given
        if checkpoint is None:
            settings = seeded_settings(row, plan, seed, detectors.get(seed))
            try:
                checkpoint = _trained(settings, data, folder, say, row)
            except InputError as error:
                return Result((), f"not run: {error}")
        known = _report_of(checkpoint, data, plan.split, folder / "report", detectors.get(seed), say)
        reports.append(known)
        facts = _facts(checkpoint, data, plan)
    return Result(tuple(reports), facts=facts)


def check_checkpoint(row: Row, common: TrainSettings, path: Path) -> None:
    """Refuse a checkpoint of another network than its row's, or of another number of views.

    Raises
    ------
    InputError
        Naming the row and both.
    """
    wanted, found = row_settings(row, common), load_network(path)[1]
    titles = [f"{one.network.variant} {one.network.name} of {one.views.count} views" for one in (wanted, found)]
    if titles[0] != titles[1]:
        raise InputError(f"checkpoints: {row.name}", titles[0], f"{titles[1]}, {path}")


def seeded_settings(row: Row, plan: Plan, seed: int, detector: Path | None) -> TrainSettings:
    """Return the settings of one run of a row."""
    settings = row_settings(row, plan.settings)
    steps = max(plan.samples // settings.batch, _FEWEST_STEPS)
    every = max(steps // 10, 1)
    changes: dict[str, Any] = {
        "steps": steps,
        "seed": settings.seed + seed,
        "save_every": min(settings.save_every, every),
        "validate_every": max(steps // 4, 1),
        "optimiser": settings.optimiser.model_copy(update={"warmup": min(settings.optimiser.warmup, steps // 10)}),
    }
    if row.needs_detector:
        options = settings.network.densefusion.model_copy(update={"completion": detector})
        changes["network"] = settings.network.model_copy(update={"densefusion": options})
    return settings.model_copy(update=changes)


def detector_of(out: Path, seeds: int, checkpoints: Mapping[str, Path]) -> dict[int, Path]:
    """Return the checkpoints of the detector by seed: those that are trained, or the given one for all."""
    if DETECTOR in checkpoints:
        return dict.fromkeys(range(seeds), checkpoints[DETECTOR])
    paths = {seed: _chosen(out / "runs" / f"{DETECTOR}-{seed}") for seed in range(seeds)}
    return {seed: path for seed, path in paths.items() if path.is_file()}


def _trained(settings: TrainSettings, data: Path, folder: Path, say: Callable[[str], None], row: Row) -> Path:
    last = folder / LAST
    if last.is_file() and load_checkpoint(last).step >= settings.steps:
        return _chosen(folder)
    say(f"{row.title}, seed {settings.seed}: {settings.steps} steps")
    train(settings, data, folder, last if last.is_file() else None, say)
    return _chosen(folder)


def _chosen(folder: Path) -> Path:
    """Return the checkpoint of the least validation loss, or the last one where there is no validation."""
    return folder / BEST if (folder / BEST).is_file() else folder / LAST


def _report_of(
    checkpoint: Path, data: Path, split: SplitName, folder: Path, detector: Path | None, say: Callable[[str], None]
) -> dict[str, Any]:
    path = folder / "report.json"
    known_by = detector if _network_name(checkpoint) in ("keypose", "densefusion") else None
    if path.is_file() and path.stat().st_mtime >= checkpoint.stat().st_mtime:
        known = read_json(path)
        same_detector = known_by is None or "detector" in known.get("locations", {})
        if known["checkpoint"] == str(checkpoint) and known["data"]["split"] == split and same_detector:
            return known
    return evaluate(checkpoint, data, split, folder, say, worst=2, detector=known_by)


def _network_name(checkpoint: Path) -> NetworkName:
    return load_network(checkpoint)[1].network.name


def _facts(checkpoint: Path, data: Path, plan: Plan) -> dict[str, float]:
    """Return parameters [1e6] and cost of a pass [1e9 multiplications and additions] of a network, and what it saw."""
    network, settings = load_network(checkpoint)
    samples = samples_of(settings, data, plan.split, ground_truth=True)
    batch = collate([samples[(0, 0)]])
    with torch.inference_mode(), FlopCounterMode(display=False) as counter:
        outputs_of(network, batch, settings.network)
    return {
        "parameters": sum(value.numel() for value in network.parameters()) / 1e6,
        "gmac": counter.get_total_flops() / 2e9,
        "seen": float(settings.steps * settings.batch),
        "evaluated": float(len(samples)),
    }


def _step_seconds(row: Row, common: TrainSettings, data: Path) -> float:
    """Return the time of a training step of a row; that of the true depth for completed depth, which comes first."""
    settings = row_settings(row, common)
    if row.needs_detector:
        options = settings.network.densefusion.model_copy(update={"depth": "true"})
        settings = settings.model_copy(update={"network": settings.network.model_copy(update={"densefusion": options})})
    settings = with_own_views(settings.model_copy(update={"val_split": "none"}))
    with tempfile.TemporaryDirectory() as folder:
        try:
            state = set_up_training(settings, data, Path(folder))
            batches = [
                collate([state.train[(index % len(state.train), draw)] for index in range(settings.batch)])
                for draw in range(_MEASURED + 1)
            ]
        except InputError:
            return 0.0  # it cannot be run on this data, and its row will say why
    start = perf_counter()
    for number, batch in enumerate(batches):
        if number == 1:
            start = perf_counter()
        outputs = outputs_of(state.network.train(), batch, settings.network, 0.0)
        loss = total_loss(losses_of(outputs, batch, state.settings), settings.losses)
        state.optimiser.zero_grad(set_to_none=True)
        loss.backward()
        state.optimiser.step()
    return (perf_counter() - start) / _MEASURED
