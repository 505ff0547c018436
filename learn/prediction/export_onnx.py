"""A network as an ONNX file for other runtimes, compared with torch before it is handed out.

The batch is one sample, and the size of the pictures and the number of views are fixed; poses and intrinsic matrices
are inputs, so one file serves any cameras. Depth planes are those of the training.
"""

from __future__ import annotations

import logging
import math
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import onnxruntime
import torch
from torch import Tensor, nn

from ...core.atomic_io import write_atomically
from ...core.errors import InputError
from ...core.exit_codes import WorkFailed
from ...core.json_file import json_text
from ...core.silence import quiet
from ..evaluation.score import eval_mode
from ..networks.mvtrans import MVTrans
from ..networks.settings import SIZE_MULTIPLE
from .predictor import Predictor

#: Inputs: (1, V, 3, H, W) in [0, 1], (1, V, 4, 4) [m], (1, V, 3, 3) [px].
INPUTS = ("images", "world_T_camera", "K")
#: Outputs from which objects are decoded, and depth; their units are those of `MVTrans.forward`.
OUTPUTS = ("seg", "depth", "heatmap", "offset", "vertex", "z_centroid", "covariance")
#: The first set of operators that samples a grid (16) with what the exporter is written for.
_OPSET = 18
#: Largest difference from torch of an output, over its largest value or 1.
TOLERANCE = 1e-4
#: Fraction of the pixels of depth, and of the depths of boxes that follow from it, that may differ by more where depth
#: is chosen among those of semi-global matching: of two matches that are equally good, rounding takes one. Of pictures
#: of a plane at most 8e-4 did (`large`, 8 pairs).
TIES = 2e-3
#: Outputs with such pixels.
_CHOSEN = ("depth", "z_centroid")
#: Entry of the file's metadata with network and views.
ENTRY = "glassware"
#: Baseline of the pair that is compared [m], its focal length over its width [1], and how far away the plane is that it
#: shows [m].
_BASELINE, _FOCAL, _DISTANCE = 0.1, 1.0, 0.8
#: Waves on that plane for each colour, their shortest and longest wavelength [px], and how far they go from grey [1].
_WAVES, _WAVELENGTHS, _CONTRAST = 24, (4.0, 64.0), 0.2


@dataclass(frozen=True)
class Exported:
    """An ONNX file that was written."""

    path: Path
    size: tuple[int, int]  #: height and width of the pictures [px]
    difference: float  #: largest difference from torch, relative as for `TOLERANCE`


def export_onnx(predictor: Predictor, out: Path, size: tuple[int, int] | None = None, views: int = 2) -> Exported:
    """Write a network as ONNX.

    Parameters
    ----------
    predictor : Predictor
        With the corrected MVTrans.
    out : Path
        The file.
    size : (int, int), optional
        Height and width of the pictures [px]; by default those of the training.
    views : int
        Number of views.

    Raises
    ------
    InputError
        Where the network is another one, or no size is known.
    WorkFailed
        Where onnxruntime gives other numbers than torch (`TOLERANCE`).
    """
    network, size = predictor.network, size or predictor.settings.views.size
    if not isinstance(network, MVTrans):
        raise InputError("export-onnx", "the corrected MVTrans", type(network).__name__)
    if size is None:
        raise InputError("--size", "a height and a width, as the weights name none", "none")
    if any(side % SIZE_MULTIPLE or side < SIZE_MULTIPLE for side in size):
        raise InputError("--size", f"multiples of {SIZE_MULTIPLE} px", f"{size[0]} x {size[1]}")
    wrapped = eval_mode(_Fields(network.to("cpu")))
    with _silent():
        program = torch.onnx.export(
            wrapped,
            example_inputs(size, views, seed=0),
            dynamo=True,
            verbose=False,
            input_names=list(INPUTS),
            output_names=list(OUTPUTS),
            opset_version=_OPSET,
        )
    assert program is not None
    model = program.model_proto
    onnx.helper.set_model_props(model, {ENTRY: json_text(_record(predictor, size, views))})
    ties = TIES if network.settings.refinement == "semi_global" else 0.0
    difference = greatest_difference(wrapped, model, size, views, ties)
    if difference > TOLERANCE:
        raise WorkFailed(f"{out}: expected outputs within {TOLERANCE:g} of torch's, found {difference:.3g}")
    write_atomically(out, model.SerializeToString())
    return Exported(out, size, difference)


def example_inputs(size: tuple[int, int], views: int, seed: int) -> tuple[Tensor, Tensor, Tensor]:
    """Return pictures of a plane with waves of colour, and cameras side by side; another seed is another plane.

    All views show the same plane, so that what is matched has one answer: in pictures of noise rounding decides.
    """
    generator = torch.Generator().manual_seed(seed)
    height, width = size
    poses = torch.eye(4).repeat(1, views, 1, 1)
    poses[0, :, 0, 3] = _BASELINE * (1.0 + 0.2 * seed) * torch.arange(views)
    focal = _FOCAL * width * (1.0 + 0.1 * seed)
    K = torch.tensor([[focal, 0.0, (width - 1) / 2], [0.0, focal, (height - 1) / 2], [0.0, 0.0, 1.0]])
    shift = focal * poses[0, :, 0, 3] / _DISTANCE  # what lies at pixel u of the first view lies at u - shift
    rows, columns = torch.arange(height)[:, None], torch.arange(width) + shift[:, None, None]  # (h, 1), (V, 1, w)
    longer, angle, phase = torch.rand(3, _WAVES, 3, 1, 1, 1, generator=generator)
    number = 2.0 * math.pi / (_WAVELENGTHS[0] * (_WAVELENGTHS[1] / _WAVELENGTHS[0]) ** longer)  # of radians a pixel
    along = columns * (2.0 * math.pi * angle).cos() + rows * (2.0 * math.pi * angle).sin()
    waves = (number * along + 2.0 * math.pi * phase).sin().sum(0) / math.sqrt(_WAVES / 2.0)  # (3, V, h, w)
    images = (0.5 + _CONTRAST * waves).clamp(0.0, 1.0).movedim(0, 1)
    return images[None], poses, K.repeat(1, views, 1, 1)


def session(model: onnx.ModelProto | Path, threads: int | None = None) -> onnxruntime.InferenceSession:
    """Return a session of onnxruntime on the CPU, with a number of threads; all cores by default."""
    onnxruntime.disable_telemetry_events()
    options = onnxruntime.SessionOptions()
    if threads is not None:
        options.intra_op_num_threads = threads
    content = str(model) if isinstance(model, Path) else model.SerializeToString()
    return onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])


def greatest_difference(
    network: nn.Module, model: onnx.ModelProto, size: tuple[int, int], views: int, ties: float = 0.0
) -> float:
    """Return the largest difference between torch and onnxruntime over two samples, relative as for `TOLERANCE`.

    It is infinite where one of them gives what is no number.

    Of depths the fraction `ties` of the pixels, those that differ most, is left out.
    """
    runtime, worst = session(model, torch.get_num_threads()), 0.0
    for seed in (1, 2):  # others than those that were traced: pictures and cameras must not be constants of the file
        inputs = example_inputs(size, views, seed)
        with torch.inference_mode():
            expected = network(*inputs)
        found = runtime.run(list(OUTPUTS), {name: value.numpy() for name, value in zip(INPUTS, inputs, strict=True)})
        for name, ours, theirs in zip(OUTPUTS, expected, found, strict=True):
            error = np.quantile(np.abs(ours.numpy() - np.asarray(theirs)), 1.0 - ties if name in _CHOSEN else 1.0)
            finite = bool(ours.isfinite().all()) and bool(np.isfinite(theirs).all())
            worst = max(worst, float(error / max(1.0, ours.abs().max())) if finite else math.inf)
    return worst


class _Fields(nn.Module):
    """The network with its outputs in a fixed order, as ONNX has them."""

    def __init__(self, network: MVTrans) -> None:
        super().__init__()
        self.network = network

    def forward(self, images: Tensor, world_T_camera: Tensor, K: Tensor) -> tuple[Tensor, ...]:
        outputs = self.network(images, world_T_camera, K)
        return tuple(outputs[name] for name in OUTPUTS)


def _record(predictor: Predictor, size: tuple[int, int], views: int) -> dict[str, Any]:
    return {
        "network": predictor.settings.network.model_dump(mode="json"),
        "fit": predictor.settings.views.fit,
        "focal": predictor.focal,
        "size": list(size),
        "views": views,
    }


@contextmanager
def _silent() -> Iterator[None]:
    """Keep the exporter's notes to its own developers from the terminal; its errors are raised."""
    loggers = [logging.getLogger("torch.onnx"), logging.getLogger("onnxscript"), logging.getLogger("onnx_ir")]
    levels = [one.level for one in loggers]
    for one in loggers:
        one.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings(), quiet():
            warnings.simplefilter("ignore")
            yield
    finally:
        for one, level in zip(loggers, levels, strict=True):
            one.setLevel(level)
