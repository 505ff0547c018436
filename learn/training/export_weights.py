"""From a checkpoint of a training run to weights to use, with the record that a model card is made of."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...core.atomic_io import write_atomically
from ...core.errors import InputError
from ...core.json_file import json_text, read_json
from ...core.yaml_file import yaml_settings
from ...dataset.reader import Dataset
from ..data.scaling import fitted, fitted_K
from ..data.splits import scenes_of
from ..data.views import read_camera
from ..data.windows import stored_windows
from ..networks.build import build_network
from .checkpoint import Checkpoint, check_weights, load_checkpoint, load_trained
from .interpolated import interpolated_weights
from .settings import TrainSettings
from .weights import WeightsHeader, glassware_version, write_weights

CARD_SCHEMA = "glassware/model-card/1"
#: Part of a run's weights where they are interpolated with others: what Wortsman et al. take without a choice by data.
ALPHA = 0.5
#: Views whose cameras are read, evenly spaced: enough for a median.
_CAMERAS = 200
#: Settings of a run that say nothing about its weights.
_LEFT_OUT = {"machine", "pretrained", "log_every", "pictures_every", "save_every"}


def export_weights(
    checkpoint: Path,
    out: Path,
    name: str,
    data: Path | None = None,
    reports: Mapping[str, Path] | None = None,
    notes: Path | None = None,
    interpolate_with: Path | None = None,
    alpha: float = ALPHA,
) -> Path:
    """Write the weights of a checkpoint as OUT/NAME.safetensors, and their record as OUT/NAME.json.

    Parameters
    ----------
    checkpoint : Path
        Of `glassware train`; the averaged weights are taken where the run keeps them.
    out : Path
        Folder; it is made.
    name : str
        Name of the weights.
    data : Path, optional
        The data set that they were trained on, for the focal length and the baseline of its cameras.
    reports : mapping of Path, optional
        ``report.json`` files of `glassware evaluate`, by the words under which the model card shows them.
    notes : Path, optional
        YAML file with texts by their headings, such as ``command`` and ``machine``.
    interpolate_with : Path, optional
        A checkpoint, or weights by name, such as those that the run began with: (1 - `alpha`) of them and `alpha` of
        the checkpoint's are written.
    alpha : float
        0 to 1.

    Returns
    -------
    Path
        The file with the weights.
    """
    run = load_checkpoint(checkpoint)
    weights = run.eval_weights()
    if interpolate_with is not None:
        weights = interpolated_weights(run, load_trained(interpolate_with), alpha, interpolate_with)
    check_weights(build_network(run.settings.network).state_dict(), weights, checkpoint)
    header = _header(run, name, data)
    record = {
        "schema_version": CARD_SCHEMA,
        "name": name,
        "weights": header.model_dump(mode="json"),
        "parameters": sum(value.numel() for value in weights.values()),
        "averaged": run.ema is not None,
        "interpolated": None if interpolate_with is None else {"with": interpolate_with.stem, "alpha": alpha},
        "settings": {
            **run.settings.model_dump(mode="json", exclude=_LEFT_OUT),
            "also": [path.resolve().name for path in run.settings.also],  # their folders say nothing on another machine
        },
        "reports": {words: _report(path) for words, path in (reports or {}).items()},
        "notes": {} if notes is None else _notes(notes),
    }
    out.mkdir(parents=True, exist_ok=True)
    path = out / f"{name}.safetensors"
    write_weights(path, header, weights)
    record["bytes"] = path.stat().st_size
    write_atomically(out / f"{name}.json", json_text(record).encode())
    return path


def _header(run: Checkpoint, name: str, data: Path | None) -> WeightsHeader:
    focal, baseline = (None, None) if data is None else _median_camera(data, run.settings)
    return WeightsHeader(
        name=name,
        glassware=glassware_version(),
        network=run.settings.network,
        views=run.settings.views,
        focal=focal,
        baseline=baseline,
        step=run.step,
        data=run.data,
    )


def _median_camera(data: Path, settings: TrainSettings) -> tuple[float, float | None]:
    """Return the median focal length at the network's size [px], and the median baseline of stereo pairs [m]."""
    views = [view for scene in scenes_of(Dataset.open(data), settings.train_split) for view in scene.views]
    if not views:
        raise InputError(data, "views of the training data", "none")
    focal, baselines = [], []
    for view in views[:: max(1, len(views) // _CAMERAS)]:
        camera = read_camera(view)
        window, _ = stored_windows(camera, settings.views.convergence, view.folder)
        fit = fitted(window.size, settings.views.size, settings.views.fit)
        focal.append(fitted_K(np.array(camera.K), fit)[0, 0])
        if camera.baseline is not None:
            baselines.append(camera.baseline)
    return float(np.median(focal)), float(np.median(baselines)) if baselines else None


def _report(path: Path) -> dict[str, Any]:
    found = read_json(path)
    if not isinstance(found, dict):
        raise InputError(path, "a report of glassware evaluate", type(found).__name__)
    # A path of the machine on which it was evaluated says nothing to others.
    data = found.get("data")
    if isinstance(data, dict):
        found["data"] = {key: value for key, value in data.items() if key != "path"}
    return {key: value for key, value in found.items() if key not in ("checkpoint", "weights")}


def _notes(path: Path) -> dict[str, str]:
    found = yaml_settings(str(path), "notes")
    for heading, text in found.items():
        if not isinstance(text, str):
            raise InputError(f"{path}: {heading}", "a text", type(text).__name__)
    return found
